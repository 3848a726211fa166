"""What happens later than it should: commands on their way to the actuators, the IMU on its way to the log."""

from __future__ import annotations

from collections import deque

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.rotations import Array


def whole_steps(delay: float, timestep: float, what: str) -> int:
    """A delay (s) as time steps. InputError where it is not a whole number of them."""
    steps = round(delay / timestep)
    if abs(steps * timestep - delay) > 1e-9:
        raise InputError(problem(f"{what} {delay} s", f"a whole number of time steps of {timestep} s", "Round it."))
    return steps


class LateCommands:
    """Commands that act `steps` time steps after they were given."""

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._waiting: deque[tuple[int, Array, Array]] = deque()

    def give(self, step: int, rotor: Array, tilt: Array) -> None:
        """A command of the time step `step`."""
        self._waiting.append((step + self._steps, np.array(rotor, dtype=float), np.array(tilt, dtype=float)))

    def due(self, step: int) -> tuple[Array, Array] | None:
        """The newest command that acts from this time step on, if one begins to."""
        found = None
        while self._waiting and self._waiting[0][0] <= step:
            found = self._waiting.popleft()[1:]
        return found


class LateSamples:
    """Gyro and specific force (6,) as they were `steps` time steps ago, for rows that fall every `every` steps."""

    def __init__(self, steps: int, every: int) -> None:
        self._steps, self._every = steps, every
        self._taken: dict[int, Array] = {}

    def wanted(self, step: int) -> bool:
        """Whether a later row needs the sample of this time step."""
        return self._steps > 0 and (step + self._steps) % self._every == 0

    def take(self, step: int, sample: Array) -> None:
        """Keeps the sample of this time step."""
        self._taken[step] = np.array(sample)

    def read(self, step: int, present: Array) -> Array:
        """The sample for the row at this time step; the present one where none is old enough."""
        return self._taken.pop(step - self._steps, present)


class Filter:
    """A first-order low-pass of gyro and specific force (6,), time constant `lag` (s).

    Exact for an input that is a straight line over each step.
    """

    def __init__(self, lag: float, timestep: float) -> None:
        self._kept = float(np.exp(-timestep / lag))
        self._late = lag / timestep * (1.0 - self._kept)
        self._last = self.value = np.zeros(6)

    def settle(self, present: Array) -> None:
        """As after a long time at `present`."""
        self._last = self.value = np.array(present)

    def move(self, present: Array) -> None:
        """One time step on; `present`: the input at its end."""
        # y' = (x - y) / lag with x from `last` to `present`: what is held, the past input, the newest.
        k, late = self._kept, self._late
        self.value = k * self.value + (late - k) * self._last + (1.0 - late) * present
        self._last = np.array(present)
