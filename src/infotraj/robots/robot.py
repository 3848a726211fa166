"""Who flies a reference: the contract between a robot, its controller and the rest of the experiment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference


@dataclass(frozen=True)
class Estimate:
    """What the state estimator says: position (3,) m and velocity (3,) m/s, world; attitude (4,) w, x, y, z,
    body to world; rate (3,) rad/s, body."""

    position: Array
    attitude: Array
    velocity: Array
    rate: Array


class Controller(Protocol):
    """Turns estimates into commands at a fixed period."""

    period: float  # s

    def reset(self) -> None:
        """Forgets the last flight (integrators, warm starts)."""

    def command(self, k: int, estimate: Estimate) -> tuple[Array, Array, Array]:
        """Wrench (6,) N and N m, body frame, rotor speeds (rotors,) rad/s and tilts (tilts,) rad.

        k is the sample of the reference, which has the controller's period.
        """


class Robot(Protocol):
    """Flies a reference and brings back the flight."""

    def fly(self, reference: Reference, controller: Controller, rng: np.random.Generator) -> Flight:
        """The flight of `reference` under `controller`; `rng` draws what varies from flight to flight."""
