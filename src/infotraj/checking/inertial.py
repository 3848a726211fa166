"""What an IMU says without an attitude beside it: the size and direction of the specific force in flight."""

from __future__ import annotations

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.checking.settings import command, scale_setting
from infotraj.flight import SPECIFIC_FORCE, Flight
from infotraj.rotations import Mask

STANDARD_GRAVITY = 9.80665
# Over a flight the mean specific force balances the weight; aggressive flight raises its median size by less than half.
USUAL = (0.6, 1.7)


def force_unit_findings(flight: Flight, airborne: Mask) -> list[Finding]:
    """Unit, gravity and sign of ax, ay, az, from the median of its size and of az over the flight."""
    if not flight.has(*SPECIFIC_FORCE):
        return []
    a = flight.get(*SPECIFIC_FORCE)[airborne]
    a = a[np.isfinite(a).all(axis=1)]
    if len(a) < 50:
        return []
    size = float(np.median(np.linalg.norm(a, axis=1))) / STANDARD_GRAVITY
    upright = float(np.median(a[:, 2])) / STANDARD_GRAVITY
    values = {"median_size_in_g": size, "median_az_in_g": upright}

    def finding(code: str, what: str, setting: str, sure: float) -> list[Finding]:
        return [
            Finding(
                code,
                "reject",
                what,
                "every comparison of model and measurement would be wrong",
                command((setting,)),
                sure=sure,
                channels=SPECIFIC_FORCE,
                values=values,
                settings=(setting,),
            )
        ]

    for unit, text in ((1 / STANDARD_GRAVITY, "is in g, not m/s^2"), (STANDARD_GRAVITY, "was multiplied by g twice")):
        if USUAL[0] < size / unit < USUAL[1]:
            return finding(
                "acceleration_unit",
                f"specific force {text} (its median size is {size * STANDARD_GRAVITY:.3g}; flying takes 9.8)",
                scale_setting("specific_force", unit),
                0.99,
            )
    if size < 0.5:
        return finding(
            "acceleration_without_gravity",
            f"ax, ay, az have a median size of {size * STANDARD_GRAVITY:.3g} m/s^2: gravity is taken out",
            "specific_force.gravity_removed=true",
            0.99,
        )
    if USUAL[0] < size < USUAL[1] and upright < -0.5:
        return finding(
            "acceleration_axes",
            f"az has a median of {upright:.2g} g: z points down, or the sign is gravity's, not the specific force's",
            "specific_force.body=FRD",
            0.99,
        )
    return []
