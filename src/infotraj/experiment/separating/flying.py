"""The plant of a run: it flies the task and whatever reference it is given. What it hides stays here."""

from __future__ import annotations

from collections.abc import Callable

from infotraj.control.thrust_vector import ThrustVectorController
from infotraj.control.tracking import TrackingController
from infotraj.experiment.hidden.config import HiddenStudy
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.experiment.separating.cases import Run, SeparatingStudy, drawn, of
from infotraj.flight import COMMANDED_WRENCH, Flight
from infotraj.trajectories.reference import Reference
from infotraj.trajectories.standard import Extent, standard
from infotraj.vehicle import Vehicle, load_vehicle

SETTLE = 4.0  # s

Fly = Callable[[Reference, str], Flight]  # a reference and the flight's name, which its sensors' noise belongs to


def shown_file(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Vehicle:
    """The vehicle file as a user has it: wrong by a drawn profile."""
    vehicle = load_vehicle(hidden.vehicles[study.pairs[run.pair].vehicle].file)
    level = str(of(study, run, "level").choice(list(study.files)))
    return wrong_file(vehicle, level, of(study, run, "file"))


def plant(study: SeparatingStudy, hidden: HiddenStudy, run: Run) -> Fly:
    """Flies references on the run's plant. The controller knows the configured vehicle, not what is hidden."""
    from infotraj.robots.plant.hiding import hide
    from infotraj.robots.plant.plant import Plant  # late: mujoco

    vehicle = load_vehicle(hidden.vehicles[study.pairs[run.pair].vehicle].file)
    name, values, _ = drawn(study, hidden, run, vehicle)
    truth = hide(vehicle, [(name, values)])

    def fly(reference: Reference, what: str) -> Flight:
        controller: TrackingController | ThrustVectorController
        controller = (TrackingController if vehicle.tilts else ThrustVectorController)(vehicle, reference)
        flight = Plant(vehicle, truth, settle=SETTLE).fly(reference, controller, of(study, run, "noise", what))
        # The commanded wrench is of another file than the one that is shown.
        return Flight(flight.table.drop(columns=list(COMMANDED_WRENCH), errors="ignore"), flight.meta)

    return fly


def task(study: SeparatingStudy, run: Run, what: str = "task") -> list[Reference]:
    """The references of the task's flights; `what`: other draws of the same kinds."""
    f = study.task
    extent = Extent(f.size, f.pace, f.low, f.tilt, f.speed)
    return [standard(kind, f.seconds, extent, of(study, run, what, k)) for k, kind in enumerate(f.train)]
