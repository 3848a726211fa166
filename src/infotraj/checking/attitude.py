"""What an attitude column may really hold: each reading turns the declared quaternion into the true one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.rotations import Array

# World rotations that take NED (and north-west-down) to z up, and the body rotation between FRD and FLU.
NED_TO_ENU = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
HALF_TURN_X = np.array([0.0, 1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Reading:
    """One reading of the attitude: `true(q)` (n, 4) from the declared q; `what` finishes "the attitude ..."; `settings`
    are what an import declares where it is so.

    `half`: only one of body and world has other axes than declared, and that is rare."""

    code: str
    name: str
    what: str
    settings: tuple[str, ...]
    true: Callable[[Array], Array]
    half: bool = False


def _reorder(*columns: int) -> Callable[[Array], Array]:
    return lambda q: q[:, columns]


def _both(left: Array, right: Array) -> Callable[[Array], Array]:
    return lambda q: rotations.multiply(rotations.multiply(left, q), right)


def unwrapped_euler(q: Array, second_start: bool = False) -> Array:
    """Roll, pitch, yaw (n, 3) rad along a path, each of the two Euler solutions and every turn chosen to follow on.

    Pitch may leave -pi/2..pi/2: angles in degrees that were taken as radians wind many times round. Which of the two
    solutions the path starts from is not known: `second_start` takes the one farther from zero.
    """
    e = rotations.to_euler(q)
    other = np.stack([e[:, 0] + np.pi, np.pi - e[:, 1], e[:, 2] + np.pi], axis=-1)
    out = np.empty_like(e)
    last = np.array([np.pi, np.pi, np.pi]) if second_start else np.zeros(3)
    for k in range(len(e)):
        first, second = (last + (c - last + np.pi) % (2 * np.pi) - np.pi for c in (e[k], other[k]))
        last = first if np.abs(first - last).sum() <= np.abs(second - last).sum() else second
        out[k] = last
    return out


def _scaled_euler(factor: float, second_start: bool = False) -> Callable[[Array], Array]:
    def true(q: Array) -> Array:
        return rotations.from_euler(*(unwrapped_euler(q, second_start) * factor).T)

    return true


def _pitch_turned(q: Array) -> Array:
    return rotations.from_euler(*(rotations.to_euler(q) * [1.0, -1.0, 1.0]).T)


_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
# Turns about z that take the declared axes to the true ones: a world or a tracked body that was set up another way.
_AGAINST = {"world": "position's", "body": "IMU's"}
_QUARTERS = tuple(
    (degrees, axes, rotations.from_euler(0.0, 0.0, np.deg2rad(degrees)))
    for degrees, axes in ((90, "-y, x, z"), (-90, "y, -x, z"), (180, "-x, -y, z"))
)

READINGS: tuple[Reading, ...] = (
    Reading("", "declared", "is as declared", (), lambda q: q),
    Reading(
        "attitude_order",
        "xyzw",
        "is stored x, y, z, w in the columns qw, qx, qy, qz",
        ("attitude.order=xyzw",),
        _reorder(3, 0, 1, 2),
    ),
    Reading(
        "attitude_order",
        "wxyz",
        "is stored w, x, y, z and was read as x, y, z, w",
        ("attitude.order=wxyz",),
        _reorder(1, 2, 3, 0),
    ),
    Reading(
        "attitude_inverse",
        "world to body",
        "maps the world to the body, not the body to the world",
        ("attitude.rotates=world_to_body",),
        rotations.conjugate,
    ),
    Reading(
        "attitude_unit",
        "degrees taken as radians",
        "comes from angles in degrees that were taken as radians",
        ("attitude.unit=deg",),
        _scaled_euler(np.pi / 180),
    ),
    Reading(
        "attitude_unit",
        "degrees taken as radians, other start",
        "comes from angles in degrees that were taken as radians",
        ("attitude.unit=deg",),
        _scaled_euler(np.pi / 180, second_start=True),
    ),
    Reading(
        "attitude_unit",
        "radians taken as degrees",
        "comes from angles in radians that were taken as degrees",
        ("attitude.unit=rad",),
        _scaled_euler(180 / np.pi),
    ),
    Reading(
        "attitude_sign",
        "pitch of the other sign",
        "has a pitch of the other sign (as the Crazyflie's firmware logs it)",
        ("attitude.angle_signs=[1, -1, 1]",),
        _pitch_turned,
    ),
    Reading(
        "attitude_frame",
        "NED/FRD",
        "maps a front-right-down body to a north-east-down world",
        ("attitude.world=NED", "attitude.body=FRD"),
        _both(NED_TO_ENU, HALF_TURN_X),
    ),
    Reading(
        "attitude_frame",
        "NWU/FRD both turned",
        "has y and z of both body and world pointing the other way (front-right-down, z down)",
        ("attitude.world=[x, -y, -z]", "attitude.body=FRD"),
        _both(HALF_TURN_X, HALF_TURN_X),
    ),
    Reading(
        "attitude_frame",
        "FRD body",
        "is that of a front-right-down body in a world with z up",
        ("attitude.body=FRD",),
        _both(_IDENTITY, HALF_TURN_X),
        half=True,
    ),
    Reading(
        "attitude_frame",
        "NED world",
        "is that of a front-left-up body in a north-east-down world",
        ("attitude.world=NED",),
        _both(NED_TO_ENU, _IDENTITY),
        half=True,
    ),
    Reading(
        "attitude_frame",
        "z-down world",
        "is that of a front-left-up body in a world with y and z pointing the other way",
        ("attitude.world=[x, -y, -z]",),
        _both(HALF_TURN_X, _IDENTITY),
        half=True,
    ),
    *(
        Reading(
            "attitude_frame",
            f"{side} turned by {degrees}",
            f"is that of a {side} that is turned by {degrees} degrees about z against the {_AGAINST[side]}",
            (f"attitude.{side}=[{axes}]",),
            _both(turn, _IDENTITY) if side == "world" else _both(_IDENTITY, rotations.conjugate(turn)),
            half=side == "world",
        )
        for degrees, axes, turn in _QUARTERS
        for side in ("world", "body")
    ),
)
