"""A simulated vehicle that hides effects, the file that a user has of it, and the task's references."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from infotraj.control.thrust_vector import ThrustVectorController
from infotraj.control.tracking import TrackingController
from infotraj.experiment.hidden.config import Flights
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.flight import COMMANDED_WRENCH, Flight
from infotraj.trajectories.reference import Reference
from infotraj.trajectories.standard import Extent, standard
from infotraj.vehicle import Vehicle

SETTLE = 4.0  # s

Fly = Callable[[Reference, str], Flight]  # a reference and the flight's name, which its sensors' noise belongs to
Draws = Callable[..., np.random.Generator]  # a run's own random numbers for one purpose


def file_of(vehicle: Vehicle, levels: Sequence[str], of: Draws) -> Vehicle:
    """The vehicle file as a user has it: wrong by a profile that is drawn from `levels`."""
    return wrong_file(vehicle, str(of("level").choice(list(levels))), of("file"))


def plant(vehicle: Vehicle, hidden: Sequence[tuple[str, Mapping[str, Any]]], of: Draws) -> Fly:
    """Flies references on a plant that hides `hidden`, names with their numbers. The controller knows `vehicle`."""
    from infotraj.robots.plant.hiding import hide
    from infotraj.robots.plant.plant import Plant  # late: mujoco

    truth = hide(vehicle, [(name, dict(values)) for name, values in hidden])

    def fly(reference: Reference, what: str) -> Flight:
        controller: TrackingController | ThrustVectorController
        controller = (TrackingController if vehicle.tilts else ThrustVectorController)(vehicle, reference)
        flight = Plant(vehicle, truth, settle=SETTLE).fly(reference, controller, of("noise", what))
        # The commanded wrench is of another file than the one that is shown.
        return Flight(flight.table.drop(columns=list(COMMANDED_WRENCH), errors="ignore"), flight.meta)

    return fly


def task(flights: Flights, of: Draws, what: str = "task") -> list[Reference]:
    """The references of the task's flights; `what`: other draws of the same kinds."""
    f = flights
    extent = Extent(f.size, f.pace, f.low, f.tilt, f.speed)
    return [standard(kind, f.seconds, extent, of(what, k)) for k, kind in enumerate(f.train)]
