"""Where the rotors of common multirotors stand, which way they turn, and in which order the firmware counts them.

Angles are from the nose, to the right, seen from above (deg). Orders and spins of quad_x stand in docs/vehicle.md with
their sources; those of the others are ArduPilot's (AP_MotorsMatrix) and PX4's airframe reference.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infotraj.errors import UsageError, problem


class Place(NamedTuple):
    """One rotor: angle from the nose to the right (deg), spin (+1 counter-clockwise seen from above)."""

    angle: float
    spin: int


_AUTOPILOTS = ("px4", "ardupilot")
_QUAD_X = ((45, 1), (-135, 1), (-45, -1), (135, -1))
_HEXA_X = ((90, -1), (-90, 1), (-30, -1), (150, 1), (30, 1), (-150, -1))
_HEXA_PLUS = ((0, -1), (180, 1), (-120, -1), (60, 1), (-60, 1), (120, -1))
_OCTO_PLUS = ((0, -1), (180, -1), (45, 1), (135, 1), (-45, 1), (-135, 1), (-90, -1), (90, -1))
_OCTO_X = ((22.5, -1), (-157.5, -1), (67.5, 1), (157.5, 1), (-22.5, 1), (-112.5, 1), (-67.5, -1), (112.5, -1))
# (layout, order): the rotors in the order of the log's columns.
_TABLE = {
    **{("quad_x", firmware): _QUAD_X for firmware in _AUTOPILOTS},
    ("quad_x", "betaflight"): ((135, -1), (45, 1), (-135, 1), (-45, -1)),
    ("quad_x", "crazyflie"): ((45, 1), (135, -1), (-135, 1), (-45, -1)),
    **{("quad_plus", firmware): ((90, 1), (-90, 1), (0, -1), (180, -1)) for firmware in _AUTOPILOTS},
    **{("hexa_x", firmware): _HEXA_X for firmware in _AUTOPILOTS},
    **{("hexa_plus", firmware): _HEXA_PLUS for firmware in _AUTOPILOTS},
    **{("octo_x", firmware): _OCTO_X for firmware in _AUTOPILOTS},
    **{("octo_plus", firmware): _OCTO_PLUS for firmware in _AUTOPILOTS},
}
LAYOUTS = tuple(dict.fromkeys(layout for layout, _ in _TABLE))
ORDERS = tuple(dict.fromkeys(order for _, order in _TABLE))


def orders_of(layout: str | None) -> tuple[str, ...]:
    """The firmwares whose order of a layout is known; of any layout for None."""
    return ORDERS if layout is None else tuple(order for of, order in _TABLE if of == layout)


def places(layout: str, order: str) -> list[Place]:
    """The rotors in their order. UsageError where this firmware's order of that layout is not known."""
    if (layout, order) not in _TABLE:
        known = " or ".join(o for name, o in _TABLE if name == layout)
        remedy = "Choose one of these, and sort the rotors of the file by hand."
        raise UsageError(problem(f"the order of {order} for {layout}", known, remedy))
    return [Place(*entry) for entry in _TABLE[layout, order]]


def position(place: Place, arm: float) -> tuple[float, float, float]:
    """m, body axes (x forward, y left), of a rotor `arm` m from the middle."""
    angle = np.radians(place.angle)
    x, y = arm * np.cos(angle), -arm * np.sin(angle)
    return round(float(x), 5) + 0.0, round(float(y), 5) + 0.0, 0.0


def drawing(names: list[str], around: list[Place]) -> str:
    """The vehicle from above, nose up, as text: each rotor's name and its sense (ccw, cw)."""
    width, height = 44, 11
    rows = [[" "] * width for _ in range(height)]

    def put(x: float, y: float, text: str) -> None:
        row = round((height - 1) / 2 * (1 - x))
        column = min(max(round((width - 1) / 2 * (1 - 0.7 * y) - len(text) / 2), 0), width - len(text))
        rows[row][column : column + len(text)] = text

    put(0.0, 0.0, "+")
    put(0.4, 0.0, "^ nose")
    for name, place in zip(names, around, strict=True):
        x, y, _ = position(place, 1.0)
        put(x, y, f"{name} {'ccw' if place.spin > 0 else 'cw'}")
    return "\n".join("".join(row).rstrip() for row in rows)
