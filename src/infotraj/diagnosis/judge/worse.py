"""Axes whose error a new model makes larger on the flights it was fitted to, and the lines that say so."""

from __future__ import annotations

import numpy as np

from infotraj.comparing.equation_error import AXES
from infotraj.comparing.statistics import Statistics
from infotraj.diagnosis.judge.giving import WORSE


def worse_lines(before: Statistics, after: Statistics) -> dict[str, str]:
    """Of each axis whose error rises by more than is no difference, the line that says so."""
    rise = np.nan_to_num(after.rmse / before.rmse, nan=1.0)
    why = "a number that these flights hardly tell, something else that is missing there, or errors that made up for it"
    return {axis: f"{axis} is worse with the new model: {why}" for i, axis in enumerate(AXES) if rise[i] > WORSE}
