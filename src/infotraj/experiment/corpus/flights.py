"""Flights of the corpus's own making: exact vehicles of all sizes doing what users' vehicles do, with good sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.corpus.exact_flyer import STEP, Air, fly_exactly
from infotraj.experiment.corpus.tasks import TASKS, path
from infotraj.experiment.corpus.vehicles import MASSES, made_vehicle
from infotraj.experiment.rough.gauss_markov import gauss_markov
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.vehicle import Vehicle

# Hz, the usual ones more often
RATES = (
    100.0,
    100.0,
    100.0,
    125.0,
    200.0,
    200.0,
    200.0,
    250.0,
    250.0,
    250.0,
    500.0,
    1000.0,
)
# white noise and constant bias of good sensors and of a motion capture system, a sample; assumed
_NOISE = {
    POSITION: (5e-4, 0.0),  # m
    VELOCITY: (0.01, 0.0),  # m/s
    RATE: (0.015, 0.005),  # rad/s
    SPECIFIC_FORCE: (0.15, 0.05),  # m/s^2
}
_ATTITUDE_NOISE = 0.002  # rad
_ROTOR_NOISE = 0.002  # share of a measured speed


@dataclass(frozen=True)
class Flown:
    """A flight, the vehicle that flew it, and what it flew."""

    flight: Flight
    vehicle: Vehicle
    task: str


def exact_flight(base_seed: int, number: int, rates: tuple[float, ...] = RATES, seconds: float = 26.0) -> Flown:
    """Flight `number`: sizes and tasks take turns, the rest is drawn. It holds what the sensors read."""
    rng = generator(base_seed, "corpus flight", number)
    mass = MASSES[number % len(MASSES)]
    task = task_of(number)
    vehicle = made_vehicle(mass, rng)
    room, speed = _extent(task, mass, rng)
    places, yaw = path(task, seconds, room, speed, rng)
    wind = np.zeros((len(places), 3))
    if rng.random() < 0.5:
        # a steady wind and gusts of a fifth of it, as outdoors; lighter vehicles fly in a draught
        strength = rng.uniform(0.2, 1.0) * min(4.0, 4.0 * mass**0.5)
        heading = rng.uniform(-np.pi, np.pi)
        steady = strength * np.array([np.cos(heading), np.sin(heading), 0.0])
        wind = steady + 0.2 * strength * gauss_markov(len(places), STEP, 1.0, rng) * [1.0, 1.0, 0.5]
    air = Air(rng.uniform(0.1, 0.4), rng.uniform(0.005, 0.03), wind)
    flight = fly_exactly(vehicle, places, yaw, air, rates[rng.integers(len(rates))], rng)
    named = {**flight.meta, "source": f"{number:03d} {mass:g} kg {task}"}
    return Flown(sensed(Flight(flight.table, named), rng), vehicle, task)


def task_of(number: int) -> str:
    """What flight `number` does."""
    return tuple(TASKS)[(number // len(MASSES) + number) % len(TASKS)]


def sensed(flight: Flight, rng: np.random.Generator) -> Flight:
    """The flight with the noise of good sensors in every channel that it has."""
    table = flight.table.copy()
    for names, (noise, bias) in _NOISE.items():
        if flight.has(*names):
            table[list(names)] += noise * rng.standard_normal((len(table), 3)) + bias * rng.standard_normal(3)
    if flight.has(*ATTITUDE):
        turned = rotations.exp(_ATTITUDE_NOISE * rng.standard_normal((len(table), 3)))
        table[list(ATTITUDE)] = rotations.multiply(flight.get(*ATTITUDE), turned)
    for name in table.columns[table.columns.str.match(r"rotor_\d+$")]:
        table[name] *= 1.0 + _ROTOR_NOISE * rng.standard_normal(len(table))
    return Flight(table, dict(flight.meta))


def _extent(task: str, mass: float, rng: np.random.Generator) -> tuple[float, float]:
    """Half the room (m) and the greatest speed (m/s): a small vehicle in a hall, a large one outdoors."""
    hall = 1.0 if mass < 0.1 else 2.5 if mass < 1.0 else 6.0
    room = rng.uniform(0.6, 1.0) * hall
    # of a path of that size, no more than 0.6 g
    fastest = min(8.0, np.sqrt(6.0 * room))
    if task in ("gentle eight", "vertical"):
        return min(room, 2.0), min(1.0, 0.4 * fastest)
    return room, rng.uniform(0.6, 1.0) * (fastest if task != "steps" else 0.5 * fastest)
