"""A pool of recorded flights as a robot: it can fly what was flown, and answers with the record."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.signal import savgol_filter

from infotraj import flight as columns
from infotraj import rotations
from infotraj.errors import UsageError, problem
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference

GRAVITY = 9.81
_STEP = 0.01  # s
_SMOOTHING = 31  # samples: the logged set-point holds values over lost packets, its derivatives need a filter


class Pool:
    """Recorded flights by name, each with the reference that its set-points describe."""

    def __init__(self, recorded: Mapping[str, Flight]) -> None:
        self.recorded = dict(recorded)
        self._references = {name: set_point_reference(one) for name, one in self.recorded.items()}

    @property
    def names(self) -> list[str]:
        """The flights' names, in order."""
        return list(self.recorded)

    def reference(self, name: str) -> Reference:
        """What the named flight was asked to fly. UsageError for a name that is not in the pool."""
        if name not in self._references:
            raise UsageError(problem(f"no flight {name} in the pool", f"one of {', '.join(self.names)}", "Choose one."))
        return self._references[name]

    def fly(self, reference: Reference) -> Flight:
        """The recorded flight of this reference. UsageError where the pool holds no flight of it."""
        for name, known in self._references.items():
            if len(known.t) == len(reference.t) and np.allclose(known.position, reference.position, rtol=0, atol=1e-9):
                return self.recorded[name]
        raise UsageError(
            problem(
                "the reference was never flown",
                f"a reference of one of the {len(self.recorded)} flights of the pool",
                "A pool flies only what was recorded: take it from `Pool.reference`.",
            )
        )


def set_point_reference(recorded: Flight) -> Reference:
    """The reference that a flight's logged set-points (ref_px.., ref_qw..) describe, on a 10 ms grid.

    Derivatives by a Savitzky-Golay filter (31 samples, order 3). The attitude is what a vehicle without drag and
    with thrust along body z needs (differential flatness; Mellinger and Kumar 2011, eq. 4 to 6).
    """
    source = recorded.t
    t = np.arange(int((source[-1] - source[0]) / _STEP + 1e-6) + 1) * _STEP + source[0]
    set_point = recorded.get(*columns.REFERENCE_POSITION)
    set_point = np.column_stack([np.interp(t, source, column) for column in set_point.T])
    yaw = np.unwrap(rotations.to_euler(recorded.get(*columns.REFERENCE_ATTITUDE))[:, 2])
    position, velocity, acceleration = (
        savgol_filter(set_point, _SMOOTHING, 3, deriv=order, delta=_STEP, axis=0) for order in range(3)
    )
    attitude = flat_attitude(acceleration, np.interp(t, source, yaw))
    rate = _difference(attitude, _STEP)
    return Reference(
        t=t,
        position=position,
        attitude=attitude,
        velocity=velocity,
        rate=rate,
        acceleration=acceleration,
        angular_acceleration=np.gradient(rate, _STEP, axis=0),
    )


def flat_attitude(acceleration: Array, yaw: Array) -> Array:
    """Attitude (n, 4) whose body z carries acceleration (n, 3) plus gravity, with the heading yaw (n,) rad."""
    z = acceleration + np.array([0.0, 0.0, GRAVITY])
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    # In the frame turned by yaw, body z = (sin(pitch) cos(roll), -sin(roll), cos(pitch) cos(roll)).
    x_heading = z[:, 0] * np.cos(yaw) + z[:, 1] * np.sin(yaw)
    y_heading = -z[:, 0] * np.sin(yaw) + z[:, 1] * np.cos(yaw)
    return rotations.continuous(rotations.from_euler(-np.arcsin(y_heading), np.arctan2(x_heading, z[:, 2]), yaw))


def _difference(attitude: Array, step: float) -> Array:
    turn = rotations.log(rotations.multiply(rotations.conjugate(attitude[:-1]), attitude[1:])) / step
    return np.concatenate([turn, turn[-1:]])
