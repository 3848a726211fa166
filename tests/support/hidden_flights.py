"""Flights of the MuJoCo plant with effects hidden in its truth, for the tests of the diagnosis."""

import numpy as np

from infotraj import rotations
from infotraj.control.tracking import TrackingController
from infotraj.robots.plant.plant import Plant
from infotraj.robots.plant.truth import Truth
from infotraj.trajectories.reference import from_poses
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")


def truth(air=None, rotors=None, **body):
    """The plant without hidden effects, with some numbers replaced."""
    ideal = Truth.ideal(OMAV)
    return ideal.model_copy(
        update={
            **body,
            "air": ideal.air.model_copy(update=air or {}),
            "rotors": ideal.rotors.model_copy(update=rotors or {}),
        }
    )


def path(seconds, seed):
    """A smooth reference in place and attitude, from rest to rest."""
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(round(seconds / 0.01) + 1)
    rise = np.clip(np.minimum(t, seconds - t) / 1.5, 0.0, 1.0)
    window = rise**3 * (10 - 15 * rise + 6 * rise**2)

    def wave(size, slow, fast):
        a, b = rng.uniform(0, 2 * np.pi, 2)
        return window * size * (np.sin(slow * t + a) + 0.3 * np.sin(fast * t + b))

    place = np.stack([wave(0.6, 1.6, 3.3), wave(0.6, 1.3, 2.9), 1.5 + wave(0.3, 1.9, 3.9)], axis=1)
    angles = wave(0.3, 1.7, 3.1), wave(0.3, 1.4, 2.7), wave(0.6, 1.1, 2.3)
    return from_poses(t, place, rotations.from_euler(*angles))


def fly(hidden, flights=3, seconds=9.0):
    """Flights of a plant with this truth, on different paths and with different noise."""
    made = []
    for seed in range(flights):
        reference = path(seconds, seed)
        plant = Plant(OMAV, hidden)
        made.append(plant.fly(reference, TrackingController(OMAV, reference), np.random.default_rng(100 + seed)))
    return made
