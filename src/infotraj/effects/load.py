"""A load that swings on a cable."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from infotraj.effects.along import Along, OriginPath
from infotraj.effects.base import Effect, Load, Parameter
from infotraj.effects.first_swing import LEARNED, STATES, first_swing
from infotraj.rotation_matrices import turned_back
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_STEP = 0.005  # s, at most; a hundredth of the period of the shortest cable in use
_BEGUN = 0.02  # s, for the first state alone: a twentieth of that period
_AT_REST = 0.1  # m/s
_FIRST = 0.1  # s of specific force from which the first direction is taken


class SuspendedLoad(Effect):
    """A point mass on a taut massless cable from the body's origin, without air drag.

    With the unit vector q from the origin to the load and the specific force f of the origin (world axes), the load
    moves by q'' = -|q'|^2 q - (f - (q . f) q) / length, and the cable pulls the origin along q with
    mass x (length |q'|^2 - q . f): Sreenath, Lee and Kumar, "Geometric control and differential flatness of a quadrotor
    UAV with a cable-suspended load" (2013), eq. 1-2, with the origin's motion given. The load is integrated along the
    recorded motion; its own pull on f is part of the prediction. In the flight's first row it is near rest against the
    origin: straight below it where the origin is at rest (below 0.1 m/s), else along the specific force there (of the
    straight line through the first 0.1 s). How near is found from the flight, where its sensors show it (first_swing).
    """

    name = "suspended_load"
    place = "wrench"
    parameters = (
        Parameter("mass", "kg", 0.1, (0.0, 10.0)),
        Parameter("length", "m", 0.2, (0.05, 5.0), absent=0.6, meaning="of the cable; says nothing without a mass"),
    )
    mass: float
    length: float
    needs = ("mass", "body motion", "specific force")
    needs_to_act = ("mass", "body motion")
    states = STATES
    source = "Sreenath, Lee and Kumar (2013), eq. 1-2"

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.1 * vehicle.known_mass() if parameter.name == "mass" else parameter.scale

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        return (0.0, vehicle.known_mass()) if parameter.name == "mass" else parameter.bounds

    @classmethod
    def starts(cls, vehicle: Vehicle, parameters: tuple[Parameter, ...]) -> list[dict]:
        return [{"mass": 0.1 * vehicle.known_mass(), "length": length} for length in (0.3, 0.45, 0.65, 1.0)]

    def is_absent(self, vehicle: Vehicle) -> bool:
        return self.mass == 0.0

    def load(self, along: Along) -> Load:
        assert along.of_flight is not None  # a load needs the whole flight
        start, step, states = along.of_flight(("suspended_load", self.length), self._swing)
        q, q_dot = _between(states, (along.time - start) / step, step)
        direction = turned_back(along.attitude, q)
        return Load(direction, self.length * np.einsum("ni,ni->n", q_dot, q_dot), self.mass)

    def _swing(self, path: OriginPath) -> tuple[float, float, Array]:
        """Start, step and states q, q', q'' (m, 3, 3) of the load along the flight, world axes."""
        steps = max(2, math.ceil((path.stop - path.start) / _STEP))
        step = (path.stop - path.start) / steps
        force = path.at(path.start + 0.5 * step * np.arange(2 * steps + 1, dtype=float))
        up = np.array([0.0, 0.0, 1.0])
        if not path.first_speed < _AT_REST:
            early = np.arange(0, max(2, round(_FIRST / step)) * 2 + 1)[: len(force)]
            line = np.polynomial.polynomial.polyfit(early, force[early], 1)[0]
            up = line / np.linalg.norm(line)
        first, rate = -up, np.zeros(3)
        if path.across is not None:
            every = min(max(1, round(_BEGUN / step)), steps)
            count = min(steps, math.floor(LEARNED / step)) // every
            time = path.start + every * step * np.arange(count + 1, dtype=float)
            begun = np.ascontiguousarray(force[: 2 * every * count + 1 : every])

            def swing(q: Array, q_dot: Array) -> tuple[Array, Array]:
                states = _swing(begun, every * step, self.length, q, q_dot)
                q, q_dot = states[:, 0], states[:, 1]
                along = np.einsum("ni,ni->n", q, begun[::2])
                return q, self.length * np.einsum("ni,ni->n", q_dot, q_dot) - along

            free = math.sqrt(float(np.linalg.norm(force.mean(axis=0))) / self.length)
            first, rate = first_swing(path.across, swing, time, first, free)
        return path.start, step, _swing(force, step, self.length, first, rate)


@njit(cache=True)
def _between(states: Array, place: Array, step: float) -> tuple[Array, Array]:
    """q and q' at fractional steps `place` (N,): the quintic that has value, slope and curvature at both ends."""
    q, q_dot = np.empty((len(place), 3)), np.empty((len(place), 3))
    for n in range(len(place)):
        k = min(max(int(place[n]), 0), len(states) - 2)
        u = min(max(place[n] - k, 0.0), 1.0)
        a, b = states[k], states[k + 1]
        size = 0.0
        for i in range(3):
            c0, c1, c2 = a[0, i], a[1, i] * step, 0.5 * a[2, i] * step**2
            d0 = b[0, i] - c0 - c1 - c2
            d1 = b[1, i] * step - c1 - 2 * c2
            d2 = 0.5 * b[2, i] * step**2 - c2
            c3, c4, c5 = 10 * d0 - 4 * d1 + d2, -15 * d0 + 7 * d1 - 2 * d2, 6 * d0 - 3 * d1 + d2
            q[n, i] = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
            q_dot[n, i] = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / step
            size += q[n, i] * q[n, i]
        size = np.sqrt(size)
        for i in range(3):
            q[n, i] /= size
    return q, q_dot


@njit(cache=True)
def _swing(force, step, length, first, rate):
    """Runge-Kutta of fourth order; force (2 m + 1, 3) at full and half steps."""
    count = (len(force) + 1) // 2
    out = np.empty((count, 3, 3))
    q, v = (first[0], first[1], first[2]), (rate[0], rate[1], rate[2])
    for n in range(count):
        a1 = _acceleration(q, v, force[2 * n], length)
        for i in range(3):
            out[n, 0, i], out[n, 1, i], out[n, 2, i] = q[i], v[i], a1[i]
        if n == count - 1:
            break
        q2, v2 = _moved(q, v, 0.5 * step), _moved(v, a1, 0.5 * step)
        a2 = _acceleration(q2, v2, force[2 * n + 1], length)
        q3, v3 = _moved(q, v2, 0.5 * step), _moved(v, a2, 0.5 * step)
        a3 = _acceleration(q3, v3, force[2 * n + 1], length)
        q4, v4 = _moved(q, v3, step), _moved(v, a3, step)
        a4 = _acceleration(q4, v4, force[2 * n + 2], length)
        q = _moved(q, _mean(v, v2, v3, v4), step)
        v = _moved(v, _mean(a1, a2, a3, a4), step)
        size = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
        q = (q[0] / size, q[1] / size, q[2] / size)
        along = q[0] * v[0] + q[1] * v[1] + q[2] * v[2]
        v = _moved(v, q, -along)
    return out


@njit(cache=True)
def _moved(x, by, factor):
    return (x[0] + factor * by[0], x[1] + factor * by[1], x[2] + factor * by[2])


@njit(cache=True)
def _mean(a, b, c, d):
    """Their mean, those in the middle twice."""
    return (
        (a[0] + 2 * b[0] + 2 * c[0] + d[0]) / 6,
        (a[1] + 2 * b[1] + 2 * c[1] + d[1]) / 6,
        (a[2] + 2 * b[2] + 2 * c[2] + d[2]) / 6,
    )


@njit(cache=True)
def _acceleration(q, v, f, length):
    fast = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    along = q[0] * f[0] + q[1] * f[1] + q[2] * f[2]
    return (
        -fast * q[0] - (f[0] - along * q[0]) / length,
        -fast * q[1] - (f[1] - along * q[1]) / length,
        -fast * q[2] - (f[2] - along * q[2]) / length,
    )
