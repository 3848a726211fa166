"""`--fail-above force=N,torque=NM`: the greatest RMSE that a model may have, an axis."""

from __future__ import annotations

import math

import numpy as np

from infotraj.comparing.comparison import Compared
from infotraj.comparing.equation_error import AXES
from infotraj.errors import InputError, UsageError, problem

KINDS = {"force": slice(0, 3), "torque": slice(3, 6)}


def parse_thresholds(text: str) -> dict[str, float]:
    """{"force": N, "torque": N m} from "force=0.5,torque=0.1". UsageError for anything else."""
    found: dict[str, float] = {}
    for part in (p.strip() for p in text.split(",")):
        name, _, value = part.partition("=")
        try:
            limit = float(value)
        except ValueError:
            limit = math.nan
        if name not in KINDS or name in found or not (math.isfinite(limit) and limit >= 0):
            raise UsageError(problem(f"--fail-above '{part}'", "force=N, torque=NM or both", "Correct it."))
        found[name] = limit
    return found


def passed(model: Compared, limits: dict[str, float]) -> list[str]:
    """The thresholds that the model's RMSE over all flights passes, a sentence each.

    InputError where no axis of a kind can be judged: a threshold that nobody looked at must not count as kept.
    """
    said = []
    rmse, unit = model.overall.rmse, model.errors[0].unit
    for kind, limit in limits.items():
        values, names = rmse[KINDS[kind]], AXES[KINDS[kind]]
        if not np.isfinite(values).any():
            why = next((e.reasons[a] for e in model.errors for a in names if a in e.reasons), "no row is scored")
            raise InputError(problem(f"--fail-above {kind}: {why}", f"a flight with {kind}", "Drop that threshold."))
        worst = int(np.nanargmax(values))
        if values[worst] > limit:
            said.append(f"{names[worst]} has an RMSE of {values[worst]:.4g} {unit[kind]}, above {kind}={limit:g}")
    return said
