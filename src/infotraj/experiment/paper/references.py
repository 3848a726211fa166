"""The references that the configuration names."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.experiment.common.config import ExperimentConfig
from infotraj.trajectories.reference import Reference
from infotraj.trajectories.tasks import figure_eight, pitch_task


def named(config: ExperimentConfig, name: str) -> Reference:
    """The reference `task` (Fig. 3, 4), `modified` (Fig. 5, Table I) or `pitch` (Fig. 2)."""
    if name == "pitch":
        pitch = config.pitch
        amplitude = np.radians(pitch.amplitude_deg)
        return pitch_task(amplitude, pitch.peak_acceleration, pitch.cycles, config.sample_time)
    figure = {"task": config.task, "modified": config.modified}[name]
    return figure_eight(np.radians(figure.amplitude_deg), figure.period, figure.cycles, config.sample_time)


def write(config: ExperimentConfig, *, task: Path, modified: Path, pitch: Path) -> None:
    """Writes the three references as CSV."""
    for name, path in (("task", task), ("modified", modified), ("pitch", pitch)):
        named(config, name).write(path)
