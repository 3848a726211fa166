"""A vehicle file held against a flight: is the thrust right, do the torques go the right way, and are they as large?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.rotations import Array

_UNRELATED = 0.3  # correlation below which a torque that is there is not the one that was commanded
_OFF = 0.15  # share by which a torque may be off before it is said to be: the filter and the lag take some, too
_SEEN = 3.0  # times the floor: a quieter torque says nothing


@dataclass(frozen=True)
class Seen:
    """One axis: its sentence, and whether it is as the file says."""

    axis: str
    good: bool
    sentence: str


def seen(error: EquationError, names: tuple[str, ...] = AXES) -> list[Seen]:
    """Thrust, and the three torques, of a flight against what the vehicle file predicts."""
    out = [_thrust(error)]
    for k, axis in enumerate(names[3:], start=3):
        rows = error.scored[:, k]
        if axis in error.reasons or rows.sum() < 20:
            out.append(Seen(axis, True, f"{axis}: not asked ({error.reasons.get(axis, 'too few rows')})"))
            continue
        out.append(_torque(axis, error.measured[rows, k], error.predicted[rows, k], float(error.floor[k])))
    return out


def _thrust(error: EquationError) -> Seen:
    rows = error.scored[:, 2]
    if not rows.any():
        return Seen("fz", True, f"thrust: not asked ({error.reasons.get('fz', 'no rows')})")
    share = float(error.measured[rows, 2].mean() / error.predicted[rows, 2].mean())
    if abs(share - 1.0) <= 0.03:
        return Seen("fz", True, f"thrust: the flight has {share:.3f} of what the file predicts: right")
    remedy = f"multiply the thrust of every rotor by {share:.3f}, or divide the mass by it"
    return Seen("fz", False, f"thrust: the flight has {share:.3f} of what the file predicts; {remedy}")


def _torque(axis: str, measured: Array, predicted: Array, floor: float) -> Seen:
    # About their means: what does not change is a trim, and says nothing of order and spins.
    measured, predicted = measured - measured.mean(), predicted - predicted.mean()
    sizes = float(np.std(measured)), float(np.std(predicted))
    if max(sizes) < _SEEN * floor:
        return Seen(axis, True, f"{axis}: too quiet in this flight to say")
    r = float(np.mean(measured * predicted) / (sizes[0] * sizes[1])) if min(sizes) > 0 else 0.0
    if r < _UNRELATED:
        what = "goes against" if r < -_UNRELATED else "does not go with"
        where = "spins" if axis == "tz" else "order of the rotors, or the body's axes"
        return Seen(
            axis,
            False,
            f"{axis}: the measured torque {what} the predicted one (correlation {r:.2f}); check the {where}",
        )
    share = float(np.sum(measured * predicted) / np.sum(predicted**2))
    if abs(share - 1.0) <= _OFF:
        return Seen(
            axis, True, f"{axis}: goes with the commands (correlation {r:.2f}) and is {share:.2f} as large: right"
        )
    remedy = {
        "tx": f"divide inertia.xx by {share:.2f}",
        "ty": f"divide inertia.yy by {share:.2f}",
        "tz": f"multiply moment_constant by {share:.2f}, or divide inertia.zz by it",
    }[axis]
    return Seen(
        axis, False, f"{axis}: goes with the commands (correlation {r:.2f}) and is {share:.2f} as large; {remedy}"
    )
