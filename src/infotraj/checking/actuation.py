"""With a vehicle file: can these commands carry this vehicle? A wrong unit shows as a thrust that is not the weight."""

from __future__ import annotations

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.flight import COMMANDED_FORCE, SPECIFIC_FORCE, Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

# Thrust coefficients, batteries and masses are wrong by tens of per cent; units by far more.
TOLERATED = 2.5
RPM = 60 / (2 * np.pi)
# factor on the thrust that a misread unit makes, and what it then is
ROTOR_UNITS = ((RPM**2, "rpm, not rad/s"), (RPM**-2, "rad/s that were converted from rpm"))


def carrying_findings(flight: Flight, airborne: Array, vehicle: Vehicle | None) -> list[Finding]:
    """Commanded rotors and commanded force against the weight that they carried, by medians over the flight."""
    if vehicle is None or vehicle.mass is None or airborne.sum() < 50:
        return []
    felt = vehicle.gravity
    if flight.has(*SPECIFIC_FORCE):
        felt = _median(np.linalg.norm(flight.get(*SPECIFIC_FORCE)[airborne], axis=1))
    if not 0.5 * vehicle.gravity < felt < 2 * vehicle.gravity:
        return []  # the accelerometer's unit is in question itself
    found = []
    thrust = rotor_thrust(flight, vehicle)
    if thrust is not None:
        ratio = _median(thrust[airborne]) / (vehicle.mass * felt)
        count = len(vehicle.rotors)
        found += _judged(ratio, "rotor_unit", "the rotor commands make", f"cmd_rotor_0..{count - 1}", ROTOR_UNITS)
    if flight.has(*COMMANDED_FORCE):
        size = _median(np.linalg.norm(flight.get(*COMMANDED_FORCE)[airborne], axis=1))
        units = (
            (1 / vehicle.mass, "m/s^2 (mass-normalised), not N"),
            (1 / (vehicle.mass * vehicle.gravity), "weights"),
        )
        found += _judged(
            size / (vehicle.mass * felt), "command_unit", "the commanded force is", "cmd_fx..cmd_fz", units
        )
    return found


def rotor_thrust(flight: Flight, vehicle: Vehicle) -> Array | None:
    """The size of the rotors' summed thrust vector (n,), N, commanded (else measured) and with commanded tilts; None
    where the log does not have one column for each rotor."""
    rotors, tilts = flight.numbered("cmd_rotor_"), flight.numbered("cmd_tilt_")
    if not rotors.shape[1]:
        rotors, tilts = flight.numbered("rotor_"), flight.numbered("tilt_")
    if rotors.shape[1] != len(vehicle.rotors) or (vehicle.tilts and tilts.shape[1] != len(vehicle.tilts)):
        return None
    total = np.zeros((len(flight.table), 3))
    for k, rotor in enumerate(vehicle.rotors):
        if rotor.input == "throttle" and rotor.thrust_polynomial is not None:
            thrust = np.polynomial.polynomial.polyval(rotors[:, k], rotor.thrust_polynomial)
        elif rotor.thrust_coefficient is not None:
            thrust = rotor.thrust_coefficient * rotors[:, k] ** 2
        else:
            return None
        axis = np.broadcast_to(np.asarray(rotor.axis), total.shape)
        if rotor.tilt is not None:
            axis = _turned(np.asarray(rotor.axis), np.asarray(vehicle.tilts[rotor.tilt].axis), tilts[:, rotor.tilt])
        total += thrust[:, None] * axis
    return np.linalg.norm(total, axis=1)


def _median(x: Array) -> float:
    x = x[np.isfinite(x)]
    return float(np.median(x)) if x.size else float("nan")


def _turned(vector: Array, axis: Array, angle: Array) -> Array:
    # Rodrigues' formula
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return c * vector + s * np.cross(axis, vector) + (1 - c) * (axis @ vector) * axis


def _judged(ratio: float, code: str, what: str, columns: str, units: tuple[tuple[float, str], ...]) -> list[Finding]:
    if not np.isfinite(ratio) or 1 / TOLERATED < ratio < TOLERATED:
        return []
    fitting = [text for factor, text in units if 1 / TOLERATED < ratio / factor < TOLERATED]
    guess = f": they are in {fitting[0]}" if fitting else ""
    return [
        Finding(
            code,
            "reject",
            f"{what} {ratio:.3g} times what carries the vehicle{guess}",
            "the prediction would be wrong by that factor",
            f"check the unit of {columns}, and mass and thrust coefficients in the vehicle file",
            sure=0.99 if fitting else 0.95,
            channels=(columns,),
            values={"ratio": ratio},
        )
    ]
