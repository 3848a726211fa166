"""Wrenches that neither rotors nor drag make: wind, tether, turbulence, a wall, a magnetic field."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.robots.plant.dryden import velocities
from infotraj.robots.plant.hidden import Disturbance, Turbulence
from infotraj.rotations import Array


class Disturbances:
    """Adds the wrenches of one truth to a simulation's applied force. `rows`: how many rows of `period` s will come."""

    def __init__(self, hidden: Disturbance, rows: int, period: float, rng: np.random.Generator) -> None:
        self._hidden = hidden
        self._force, self._torque = np.array(hidden.force), np.array(hidden.torque)
        self._magnetic = np.array(hidden.magnetic)
        self._gusts = gusts(hidden.turbulence, rows, period, rng) if hidden.turbulence else None
        self._wind = velocities(hidden.gusts, rows, period, rng) if hidden.gusts else np.zeros((1, 3))
        self._drag = hidden.gusts.drag if hidden.gusts else 0.0
        self._row = 0

    @property
    def wind(self) -> Array:
        """Velocity (m/s, world axes, (3,)) of the air in this row."""
        return self._wind[self._row % len(self._wind)]

    def begin(self, row: int) -> None:
        """From now on the gusts of this row."""
        self._row = row

    def add(self, position: Array, attitude: Array, applied: Array) -> None:
        """Adds to `applied` (6,): force in world axes, torque in body axes, about the body's origin."""
        force, torque = self._force + self._drag * self.wind, self._torque
        wall = self._hidden.wall
        if wall is not None:
            share = np.exp(-max(wall.place - position[0], 0.0) / wall.range)
            force = force + share * np.array([wall.pull, 0.0, -wall.sink])
            torque = torque + rotations.to_body(attitude, share * np.array(wall.torque))
        if self._magnetic.any():
            torque = torque + np.cross(self._magnetic, rotations.to_body(attitude, np.array([1.0, 0.0, 0.0])))
        if self._gusts is not None:
            gust = self._gusts[self._row]
            force = force + rotations.to_world(attitude, gust[:3])
            torque = torque + gust[3:]
        applied[:3] += force
        applied[3:] += torque


def gusts(turbulence: Turbulence, rows: int, period: float, rng: np.random.Generator) -> Array:
    """Force (N) and torque (N m) in body axes, (rows, 6): first-order Gauss-Markov, stationary from the first row."""
    keep = np.exp(-period / turbulence.correlation_time)
    fresh = rng.standard_normal((rows, 6)) * np.sqrt(1.0 - keep**2)
    found = np.empty((rows, 6))
    found[0] = rng.standard_normal(6)
    for k in range(1, rows):
        found[k] = keep * found[k - 1] + fresh[k]
    return found * np.array(3 * [turbulence.force] + 3 * [turbulence.torque])
