"""A load that swings on a cable."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from infotraj.effects.along import Along, OriginPath
from infotraj.effects.base import Effect, Load, Parameter
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_STEP = 0.005  # s, at most; a hundredth of the period of the shortest cable in use
_AT_REST = 0.1  # m/s
_FIRST = 0.1  # s of specific force from which the first direction is taken


class SuspendedLoad(Effect):
    """A point mass on a taut massless cable from the body's origin, without air drag.

    With the unit vector q from the origin to the load and the specific force f of the origin (world axes), the load
    moves by q'' = -|q'|^2 q - (f - (q . f) q) / length, and the cable pulls the origin along q with
    mass x (length |q'|^2 - q . f): Sreenath, Lee and Kumar, "Geometric control and differential flatness of a quadrotor
    UAV with a cable-suspended load" (2013), eq. 1-2, with the origin's motion given. The load is integrated along the
    recorded motion; its own pull on f is part of the prediction. In the flight's first row it is at rest against the
    origin: straight below it where the origin is at rest (below 0.1 m/s), else along the specific force there (of the
    straight line through the first 0.1 s).
    """

    name = "suspended_load"
    place = "wrench"
    parameters = (
        Parameter("mass", "kg", 0.1, (0.0, 10.0)),
        Parameter("length", "m", 0.2, (0.05, 5.0), absent=0.6, meaning="of the cable; says nothing without a mass"),
    )
    needs = ("mass", "body motion", "specific force")
    needs_to_act = ("mass", "body motion")
    source = "Sreenath, Lee and Kumar (2013), eq. 1-2"

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.1 * vehicle.mass if parameter.name == "mass" else parameter.scale

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        return (0.0, vehicle.mass) if parameter.name == "mass" else parameter.bounds

    @classmethod
    def starts(cls, vehicle: Vehicle, parameters: tuple[Parameter, ...]) -> list[dict]:
        return [{"mass": 0.1 * vehicle.mass, "length": length} for length in (0.3, 0.45, 0.65, 1.0)]

    def is_absent(self, vehicle: Vehicle) -> bool:
        return self.mass == 0.0

    def load(self, along: Along) -> Load:
        start, step, states = along.of_flight(("suspended_load", self.length), self._swing)
        q, q_dot = _between(states, (along.time - start) / step, step)
        direction = np.einsum("nji,nj->ni", along.attitude, q)
        return Load(direction, self.length * np.einsum("ni,ni->n", q_dot, q_dot), self.mass)

    def _swing(self, path: OriginPath) -> tuple[float, float, Array]:
        """Start, step and states q, q', q'' (m, 3, 3) of the load along the flight, world axes."""
        steps = max(2, math.ceil((path.stop - path.start) / _STEP))
        step = (path.stop - path.start) / steps
        force = path.at(path.start + 0.5 * step * np.arange(2 * steps + 1))
        up = np.array([0.0, 0.0, 1.0])
        if not path.first_speed < _AT_REST:
            early = np.arange(0, max(2, round(_FIRST / step)) * 2 + 1)[: len(force)]
            line = np.polynomial.polynomial.polyfit(early, force[early], 1)[0]
            up = line / np.linalg.norm(line)
        return path.start, step, _swing(force, step, self.length, -up)


def _between(states: Array, place: Array, step: float) -> tuple[Array, Array]:
    """q and q' at fractional steps `place` (N,): the quintic that has value, slope and curvature at both ends."""
    k = np.clip(place.astype(int), 0, len(states) - 2)
    u = np.clip(place - k, 0.0, 1.0)[:, None]
    a, b = states[k], states[k + 1]
    c0, c1, c2 = a[:, 0], a[:, 1] * step, 0.5 * a[:, 2] * step**2
    d0 = b[:, 0] - c0 - c1 - c2
    d1 = b[:, 1] * step - c1 - 2 * c2
    d2 = 0.5 * b[:, 2] * step**2 - c2
    c3, c4, c5 = 10 * d0 - 4 * d1 + d2, -15 * d0 + 7 * d1 - 2 * d2, 6 * d0 - 3 * d1 + d2
    q = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    q_dot = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / step
    return q / np.linalg.norm(q, axis=1, keepdims=True), q_dot


# Component by component: expressions of whole arrays take several times longer to compile.
@njit(cache=True)
def _swing(force, step, length, first):
    """Runge-Kutta of fourth order; force (2 m + 1, 3) at full and half steps."""
    count = (len(force) + 1) // 2
    out = np.empty((count, 3, 3))
    q, v = first.copy(), np.zeros(3)
    a1, a2, a3, a4 = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    q2, q3, q4 = np.empty(3), np.empty(3), np.empty(3)
    v2, v3, v4 = np.empty(3), np.empty(3), np.empty(3)
    for n in range(count):
        _acceleration(q, v, force, 2 * n, length, a1)
        for c in range(3):
            out[n, 0, c], out[n, 1, c], out[n, 2, c] = q[c], v[c], a1[c]
        if n == count - 1:
            break
        _ahead(q, v, v, a1, 0.5 * step, q2, v2)
        _acceleration(q2, v2, force, 2 * n + 1, length, a2)
        _ahead(q, v, v2, a2, 0.5 * step, q3, v3)
        _acceleration(q3, v3, force, 2 * n + 1, length, a3)
        _ahead(q, v, v3, a3, step, q4, v4)
        _acceleration(q4, v4, force, 2 * n + 2, length, a4)
        for c in range(3):
            q[c] += step / 6 * (v[c] + 2 * v2[c] + 2 * v3[c] + v4[c])
            v[c] += step / 6 * (a1[c] + 2 * a2[c] + 2 * a3[c] + a4[c])
        size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
        for c in range(3):
            q[c] /= size
        along = q[0] * v[0] + q[1] * v[1] + q[2] * v[2]
        for c in range(3):
            v[c] -= along * q[c]
    return out


@njit(cache=True)
def _ahead(q, v, q_dot, v_dot, time, q_then, v_then):
    for c in range(3):
        q_then[c] = q[c] + time * q_dot[c]
        v_then[c] = v[c] + time * v_dot[c]


@njit(cache=True)
def _acceleration(q, v, force, row, length, out):
    fast = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    pull = q[0] * force[row, 0] + q[1] * force[row, 1] + q[2] * force[row, 2]
    for c in range(3):
        out[c] = -fast * q[c] - (force[row, c] - pull * q[c]) / length
