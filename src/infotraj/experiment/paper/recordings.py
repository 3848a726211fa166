"""Recordings of a run's flights and rollouts, each with what a learned model says along it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from infotraj.experiment.common.config import ExperimentConfig
from infotraj.flight import read_flight
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.learning_data import learning_data
from infotraj.vehicle import load_vehicle


def record(
    config: ExperimentConfig, *, flights: Sequence[Path], models: Sequence[Path], recordings: Sequence[Path]
) -> None:
    """Writes a rerun recording of each flight, with the residual of its model along it."""
    from infotraj.recording import record_flight  # late: rerun

    vehicle, learning = load_vehicle(config.vehicle), config.learning
    for flown, model, path in zip(flights, models, recordings, strict=True):
        flight = read_flight(flown)
        data = learning_data(flight, vehicle, response_of_model=learning.response_of_model, window=learning.window)
        rollout = bool(flight.meta.get("simulated"))
        record_flight(path, flight, vehicle, gp=GaussianProcess.load(model), data=data, rollout=rollout)
        print(path, flush=True)
