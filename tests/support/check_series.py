"""A quadrotor's series on one clock, and flights made of them."""

from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.flight import Flight
from infotraj.vehicle import load_vehicle

QUAD = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
T = 5.0 + 0.01 * np.arange(2000)
ALL = np.ones(len(T), dtype=bool)
HOVER = np.sqrt(QUAD.known_mass() * QUAD.gravity / 4 / (QUAD.rotors[0].thrust_coefficient or np.nan))


def flight(t=T, meta=None, **columns):
    return Flight(pd.DataFrame({"t": t, **{k: np.broadcast_to(v, t.shape) for k, v in columns.items()}}), meta or {})


def random(seed, *shape):
    return np.random.default_rng(seed).standard_normal((len(T), *shape))
