"""What these flights cannot say: axes whose prediction explains nothing, and answers that no body can have."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError, equation_error
from infotraj.comparing.statistics import Statistics, statistics
from infotraj.diagnosis.gates.doubt import Doubt, reached
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array

LEAST_EXPLAINED = 0.1  # of what was measured (a torque's variance, a force's square): less is no explanation
HALF_EXPLAINED = 0.5  # the same where healthy flights tell what is usual: the rest may differ by chance
_ABOVE_FLOOR = 3.0  # an error that near the floor is small, whatever it explains
_LEAST_MOVED = 0.1  # of a measured variance that is no noise, as far as that is told from noise


def compared(model: Model, flights: Sequence[Flight], start: float | None, stop: float | None) -> list[EquationError]:
    """Equation errors of a model, flight by flight."""
    return [equation_error(model, f, start=start, stop=stop) for f in flights]


def errors(model: Model, flights: Sequence[Flight], start: float | None, stop: float | None) -> Statistics:
    """Equation error of a model over all flights, axis by axis."""
    return statistics(compared(model, flights, start, stop))


def unanswered(
    model: Model,
    flights: Sequence[Flight],
    start: float | None = None,
    stop: float | None = None,
    least: float = LEAST_EXPLAINED,
    known: AbstractSet[str] = frozenset(),
    given: Model | None = None,
) -> list[Doubt]:
    """Doubts about axes (fx .. tz) on which a fitted model explains next to nothing of what was measured.

    An axis on which the actuators do not act is not one of them: what else the model says of it is little, or named.
    What is explained is what goes with the prediction: an error that is as large as the measured side, as rotors 1 %
    different make it where a vehicle turns gently, is no disagreement; nor is one that is small beside the weight which
    the thrust carries, whatever a hover shows of its changes. least: share that is enough; known: axes that
    are refused for a reason of their own, which says nothing of others; given: the model before the fit: what it says
    of an axis is no less true for a fit that went astray, beside an axis on which no model says anything.
    """
    made = compared(model, flights, start, stop)
    after = statistics(made)
    before = np.zeros(len(AXES)) if given is None else coherence(compared(given, flights, start, stop))
    found = {}
    for i, axis in enumerate(AXES):
        if axis not in reached(model.vehicle) or axis in known:
            continue
        far = np.isfinite(after.rmse[i]) and after.rmse[i] > _ABOVE_FLOOR * after.floor[i]
        predicted = np.concatenate([e.predicted[e.scored[:, i], i] for e in made])
        says = len(predicted) > 0 and np.std(predicted) > _ABOVE_FLOOR * after.floor[i]
        explained = max(_explained(made, i), _going_with(made, i), before[i]) if far and says else 1.0
        if explained < least:
            what = f"force along {axis[1]}" if axis[0] == "f" else f"torque about {axis[1]}"
            share = f"the prediction explains {100 * explained:.0f} % of the measured {what}"
            reason = f"{share}: flights and vehicle file do not agree there (spin, order of rotors, time stamps)"
            found[axis] = Doubt("axis_disagrees", axis, (axis,), reason)
    worse = [a for i, a in enumerate(AXES) if a[0] == "t" and a in found and after.explained[i] < 0.0]
    if model.vehicle.tilts and worse:
        # Rotors that tilt make every force and torque together: where one torque is not theirs, no axis is sure.
        return [Doubt("axis_disagrees", "commands", AXES, found[worse[0]].reason)]
    return list(found.values())


def coherence(made: Sequence[EquationError]) -> Array:
    """Share (6,) of the measured force and torque that goes with a model's prediction; NaN where one is missing."""
    shown = [any(e.scored[:, i].any() for e in made) for i in range(6)]
    return np.array([_going_with(made, i) if shown[i] else np.nan for i in range(6)])


def hardly_predicted(made: Sequence[EquationError], given: Sequence[EquationError]) -> dict[str, float]:
    """Axes of torque of which less than half of what was measured goes with a model's prediction, and that share.

    What is noise of the measured side goes with nothing: the share is of the rest. given: errors of the model before
    the fit. Where both are near the floor, nothing says that a prediction fails: it may be as small as the noise.
    """
    after, before = statistics(made), statistics(given)
    far = (after.rmse > _ABOVE_FLOOR * after.floor) | (before.rmse > _ABOVE_FLOOR * before.floor)
    noise = np.minimum(after.floor, after.spread) / np.maximum(after.spread, 1e-300)
    moves = np.maximum(1.0 - noise**2, _LEAST_MOVED)
    shares = np.minimum(coherence(made) / moves, 1.0)
    return {a: float(shares[i]) for i, a in enumerate(AXES) if a[0] == "t" and far[i] and shares[i] < HALF_EXPLAINED}


def _explained(made: Sequence[EquationError], i: int) -> float:
    """Share of the measured side of one axis that the prediction takes off: of a torque's variance, of a force squared,
    for what carries the vehicle was measured, too."""
    measured = np.concatenate([e.measured[e.scored[:, i], i] for e in made])
    error = np.concatenate([e.residual[e.scored[:, i], i] for e in made])
    size = measured - measured.mean() if AXES[i][0] == "t" else measured
    return float(1.0 - np.sum(error**2) / max(np.sum(size**2), 1e-300))


def _going_with(made: Sequence[EquationError], i: int) -> float:
    """Share of the measured side of one axis that goes with the prediction, each flight's means removed, 0 to 1."""
    parts = [(e.measured[e.scored[:, i], i], e.predicted[e.scored[:, i], i]) for e in made]
    a, b = (np.concatenate([p[k] - p[k].mean() for p in parts if len(p[k])]) for k in (0, 1))
    together = a @ b / max(np.sqrt((a @ a) * (b @ b)), 1e-300)
    return float(max(together, 0.0)) ** 2


def axis_group(axis: str) -> str | None:
    """Axis fx .. tz that an axis of the residual stands for; None for kinematic ones."""
    if axis in AXES:
        return axis
    return {"vx": "fx", "vy": "fy", "vz": "fz"}.get(axis)
