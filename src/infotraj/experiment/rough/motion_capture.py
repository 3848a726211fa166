"""A log of motion capture and rotor speeds alone: late, jittering, with spikes and drop-outs."""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.experiment.rough.columns import numbered, replaced, step
from infotraj.flight import ATTITUDE, POSITION, Flight
from infotraj.vehicle import Vehicle

_LATE = 0.008  # s, exposure, reconstruction and network
_JITTER = 0.08  # of a period, standard deviation of the stamps
_RPM_STEP = 10.0 * 2.0 * np.pi / 60.0  # rad/s


def motion_capture(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Poses 8 ms late with jittering stamps; in 0.05 to 0.3 % of the rows a marker swapped (2 to 20 cm, 5 to 60 deg);
    one to three times nothing for 0.1 to 1 s; rotor speeds in steps of 10 rpm. All but the rpm is assumed."""
    t, h = flight.t, step(flight)
    pose = (*POSITION, *ATTITUDE)
    commands, speeds = numbered(flight, "cmd_rotor_"), numbered(flight, "rotor_")
    flight = Flight(flight.table[["t", *pose, *commands, *speeds]].copy(), dict(flight.meta))
    values = flight.get(*pose).copy()
    values[:, 3:] = rotations.continuous(values[:, 3:])
    seen = np.stack([np.interp(t - _LATE, t, column) for column in values.T], axis=-1)
    seen[:, 3:] = rotations.normalize(seen[:, 3:])
    swapped = np.flatnonzero(rng.random(len(t)) < rng.uniform(0.0005, 0.003))
    for k in swapped:
        seen[k, :3] += rng.uniform(0.02, 0.2) * _direction(rng)
        seen[k, 3:] = rotations.multiply(seen[k, 3:], rotations.exp(rng.uniform(0.1, 1.0) * _direction(rng)))
    for _ in range(rng.integers(1, 4)):
        start = rng.uniform(t[0] + 6.0, t[-1] - 3.0)
        seen[(t >= start) & (t < start + rng.uniform(0.1, 1.0))] = np.nan
    flight = replaced(flight, pose, seen)
    if speeds:
        flight = replaced(flight, speeds, np.round(flight.get(*speeds) / _RPM_STEP) * _RPM_STEP)
    stamps = t + np.clip(_JITTER * rng.standard_normal(len(t)), -0.45, 0.45) * h
    return replaced(flight, ("t",), stamps[:, None])


def _direction(rng: np.random.Generator) -> np.ndarray:
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)
