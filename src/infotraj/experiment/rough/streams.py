"""Logs whose rows come faster than some of their streams: what is slower is held, or absent."""

from __future__ import annotations

import numpy as np

from infotraj.experiment.rough.columns import held, step
from infotraj.flight import ATTITUDE, POSITION, VELOCITY, Flight
from infotraj.vehicle import Vehicle


def held_streams(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Poses and velocities from 100 Hz held in rows of 500 or 1000 Hz, a battery from 10 Hz; as micro-SD logs are."""
    flight = with_battery(flight, rng)
    pose = [n for n in (*POSITION, *ATTITUDE, *VELOCITY) if flight.has(n)]
    flight = held(flight, pose, max(0.01, step(flight)), rng.uniform(0.0, 0.01))
    return held(flight, ("battery",), 0.1, rng.uniform(0.0, 0.1))


def with_battery(flight: Flight, rng: np.random.Generator) -> Flight:
    """A column battery (V): a pack that empties and gives way under load, in steps of 10 mV."""
    t, speed = flight.t, flight.numbered("cmd_rotor_").mean(axis=1)
    cells = rng.integers(1, 7)
    load = (speed / np.median(speed)) ** 3
    volts = cells * (4.1 - 0.3 * (t - t[0]) / (t[-1] - t[0]) - 0.08 * load + 0.005 * rng.standard_normal(len(t)))
    return Flight(flight.table.assign(battery=np.round(volts, 2)), dict(flight.meta))
