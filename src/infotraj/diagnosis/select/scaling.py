"""How far the file is off beside a set of effects, kind by kind of its numbers."""

from __future__ import annotations

import numpy as np

from infotraj.diagnosis.select.around import Linear
from infotraj.diagnosis.select.prior import SCALES, SLAB, Scales


def scaled(now: Linear, chosen: tuple[int, ...], common: float) -> Scales:
    """How far the file is off beside a set of effects, for each kind of which it holds several numbers.

    A kind of one effect keeps the common scale: what is out of line with it is no longer a matter of the file.

    Marginal likelihood (MacKay 1992) of the file numbers that are not chosen, chosen and kept effects integrated out.
    """
    if now.observation.healthy is not None:
        return Scales(common)
    taken = sorted({*now.kept, *(c for i in chosen for c in now.choices[i].columns)})
    whole = now.absent.total
    right, gram = whole[0, 1:], whole[1:, 1:]
    labels = {now.choices[i].label for i in chosen}
    file = [int(i) for i in np.flatnonzero(now.spike(Scales(1.0)) > 0)]
    file = [i for i in file if now.columns[i].candidate.label not in labels]
    if not file:
        return Scales(common)
    of_taken = gram[taken][:, taken] + np.eye(len(taken)) / SLAB**2
    along = np.linalg.solve(of_taken, np.column_stack([gram[taken][:, file], right[taken]]))
    rest = gram[file][:, file] - gram[file][:, taken] @ along[:, :-1]
    pull = right[file] - gram[file][:, taken] @ along[:, -1]
    declared = [now.columns[i].candidate.cls.declared for i in file]
    kind = [d.kind for d in declared if d is not None]
    kinds = list(dict.fromkeys(kind))
    deviation = {s: now.spike(Scales(s))[file] for s in SCALES}
    of_kind = {k: np.array([x == k for x in kind]) for k in kinds}

    def evidence(scale: dict[str, float]) -> float:
        spread = np.zeros(len(file))
        for k in kinds:
            spread[of_kind[k]] = deviation[scale[k]][of_kind[k]]
        inside = np.eye(len(file)) + rest * np.outer(spread, spread)
        scaled = pull * spread
        return 0.5 * float(scaled @ np.linalg.solve(inside, scaled) - np.linalg.slogdet(inside)[1])

    scale = dict.fromkeys(kinds, common)
    value = evidence(scale)
    several = [
        k
        for k in kinds
        if len({now.columns[i].candidate.label for i, own in zip(file, kind, strict=True) if own == k}) > 2
    ]
    for k in several:
        for s in SCALES:
            trial = {**scale, k: s}
            reached = evidence(trial) - _apart(common, trial).cost()
            if reached > value + 1e-6:
                scale, value = trial, reached
    return _apart(common, scale)


def _apart(common: float, scale: dict[str, float]) -> Scales:
    return Scales(common, {k: s for k, s in scale.items() if s != common})
