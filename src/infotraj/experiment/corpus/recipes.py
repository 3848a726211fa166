"""The corpus: simulated flights, clean and as logs of all kinds hold them, and every real flight that can be imported.

A recipe is small and can be sent to another process; what it makes is a log with the vehicle, where there is one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fnmatch import fnmatch
from typing import Literal, Protocol

import numpy as np

from infotraj.checking import Finding, Loaded
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.corpus.flights import RATES, Flown, exact_flight, task_of
from infotraj.experiment.corpus.injected_errors import INJECTED
from infotraj.experiment.corpus.kinematic_flights import simulated
from infotraj.experiment.rough import PROFILES, Profile
from infotraj.flight import Flight
from infotraj.vehicle import Vehicle

Kind = Literal["clean", "rough"]
RESTLESS = ("gentle eight", "fast eight", "wander", "steps")  # tasks that turn and move the vehicle


@dataclass(frozen=True)
class Right:
    """Findings that are right in a log: of these codes (a pattern), where `start` is given none before it (s), and of a
    clock's lag none outside `lag` (s)."""

    code: str
    start: float | None = None
    lag: tuple[float, float] | None = None
    why: str = ""

    def covers(self, finding: Finding) -> bool:
        """Whether this finding is one of them."""
        if not fnmatch(finding.code, self.code):
            return False
        if self.start is not None and any(start < self.start - 0.5 for start, _ in finding.spans):
            return False
        if self.lag is None:
            return True
        low, high = self.lag
        return low - 0.003 <= float(finding.values.get("lag", np.inf)) <= high + 0.003


@dataclass(frozen=True)
class Log:
    """A log of the corpus. `right`: findings that are right in it; `moving`: it excites all channels, so that an error
    put into it can be seen at all; `spoiled`: the columns that one was put into."""

    source: str
    name: str
    kind: Kind
    loaded: Loaded
    vehicle: Vehicle | None = None
    right: tuple[Right, ...] = ()
    moving: bool = True
    spoiled: tuple[str, ...] = ()

    @property
    def flight(self) -> Flight:
        """The flight table."""
        return self.loaded.flight


class Recipe(Protocol):
    """How one log is made, or read."""

    @property
    def source(self) -> str:
        """Where it is from."""

    @property
    def moving(self) -> bool:
        """Whether it excites all channels."""

    def make(self) -> Log:
        """The log."""


@dataclass(frozen=True)
class ExactRecipe:
    """Flight `number` of the exact vehicles; under a log profile where one is named."""

    base_seed: int
    number: int
    profile: str = ""
    source: str = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "source", self.profile or "exact")

    @property
    def moving(self) -> bool:
        """By its task: a hover and a vertical flight hardly turn."""
        return task_of(self.number) in RESTLESS

    def make(self) -> Log:
        """Flies it and logs it."""
        if not self.profile:
            return _log("exact", "clean", exact_flight(self.base_seed, self.number))
        profile = PROFILES[self.profile]
        flown = exact_flight(self.base_seed, self.number, profile.rates or RATES)
        rng = generator(self.base_seed, "log profile", self.profile, self.number)
        seen = profile.log(flown.flight, flown.vehicle, rng)
        return _log(self.profile, "rough", Flown(seen, flown.vehicle, flown.task), _right(profile))


@dataclass(frozen=True)
class KinematicRecipe:
    """A smooth motion with all channels: a quadrotor's, or of a vehicle that turns as it likes."""

    base_seed: int
    number: int
    source: str = "kinematic"
    moving: bool = True

    def make(self) -> Log:
        """Computes it: 50 to 500 Hz, noise from a third to twice the usual."""
        k = self.number
        flight = simulated(
            1000 * self.base_seed + k,
            "quadrotor" if k % 2 else "omav",
            rate_hz=(50.0, 100.0, 200.0, 500.0)[k % 4],
            duration=26.0,
            noise=(0.33, 1.0, 2.0)[k % 3],
        )
        return Log(self.source, str(flight.meta["source"]), "clean", Loaded(flight))


@dataclass(frozen=True)
class PlantRecipe:
    """The MuJoCo omav under its own controller; under a log profile where one is named."""

    base_seed: int
    plant: str
    number: int
    profile: str = ""
    moving: bool = True
    source: str = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "source", f"mujoco omav{', ' * bool(self.profile)}{self.profile}")

    def make(self) -> Log:
        """Flies a figure of eight in attitude, or the pitching task."""
        from infotraj.experiment.common.config import ExperimentConfig
        from infotraj.experiment.paper.flying import fly, plant
        from infotraj.trajectories.tasks import figure_eight, pitch_task
        from infotraj.vehicle import load_vehicle

        config = ExperimentConfig()
        vehicle = load_vehicle(config.vehicle)
        tasks = (figure_eight(np.radians(26), 9.0, 2, 0.01), pitch_task(np.radians(60), 1.0, 2, 0.01))
        rng = generator(self.base_seed, "corpus plant", self.plant, self.number)
        flight = fly(plant(config, self.plant), vehicle, tasks[self.number % 2], None, config, rng)
        flight = Flight(flight.table, {**flight.meta, "source": f"{self.plant} task {self.number}"})
        if not self.profile:
            return Log(self.source, flight.meta["source"], "clean", Loaded(flight), vehicle)
        profile = PROFILES[self.profile]
        seen = profile.log(flight, vehicle, rng)
        return Log(self.source, flight.meta["source"], "rough", Loaded(seen), vehicle, _right(profile))


def simulated_recipes(base_seed: int, each: int) -> list[Recipe]:
    """`each` flights of the exact vehicles, clean and under every profile; as many kinematic ones; the plants' six,
    clean and as an autopilot logs them."""
    numbers = range(each)
    recipes: list[Recipe] = [ExactRecipe(base_seed, k) for k in numbers]
    # other flights under each profile, so that one odd flight does not count nine times
    for place, profile in enumerate(PROFILES):
        recipes += [ExactRecipe(base_seed, 1000 * (place + 1) + k, profile) for k in numbers]
    recipes += [KinematicRecipe(base_seed, k) for k in numbers]
    for profile in ("", "autopilot"):
        for k in range(min(6, each)):
            recipes.append(PlantRecipe(base_seed, ("omav_a", "omav_b", "omav_c")[k % 3], k // 3, profile))
    return recipes


def injected(log: Log, base_seed: int) -> Iterator[tuple[str, Log]]:
    """The log with each error that it can hold put into it, and the error's name. Streams beside the table are left
    out: the error is to be seen in the table itself."""
    for name, error in INJECTED.items():
        if error.applies(log.flight, log.vehicle):
            rng = generator(base_seed, "injected", log.source, log.name, name)
            flight = error.spoil(log.flight, log.vehicle, rng)
            changed = tuple(c for c in flight.table if not flight.table[c].equals(log.flight.table[c]))
            yield name, replace(log, loaded=Loaded(flight), spoiled=changed)


def _right(profile: Profile) -> tuple[Right, ...]:
    lags = (Right("*_clock_offset", lag=profile.lag),) if any(profile.lag) else ()
    return (*(Right(code) for code in profile.true), *lags)


def _log(source: str, kind: Kind, flown: Flown, right: tuple[Right, ...] = ()) -> Log:
    name = str(flown.flight.meta["source"])
    return Log(source, name, kind, Loaded(flown.flight), flown.vehicle, right, flown.task in RESTLESS)
