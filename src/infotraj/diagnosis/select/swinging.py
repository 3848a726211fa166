"""Finds where to linearise an effect whose column changes its shape with a number: the length of a swinging load.

An undamped swing drifts out of step with one of another length within seconds, so that no start is near enough. The
number is looked for on a grid that is fine enough for the longest flight, by what the effect gains beside all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from infotraj.diagnosis.linear.candidates import Candidate, Variant, places, read, variants, written
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.noise.spectra import binned, spectra
from infotraj.diagnosis.select.around import Linear, linearised
from infotraj.diagnosis.select.prior import SLAB, Scales
from infotraj.errors import InputError
from infotraj.rotations import Array

_RATIO = 1.04  # from one value of the grid to the next: a fiftieth of a period after one swing
_LONGEST = 20.0  # s of a flight that are scanned: a grid of this ratio stays in step about as long
_EXACT = 2e-3  # of a value of the grid: in step to the end of what is scanned
_SPAN = (0.35, 3.0)  # of the least and greatest start


def shape_of(candidate: Candidate, vehicle) -> int | None:
    """Which fitted number of a candidate changes nothing alone and has several starts; None for most effects."""
    found = variants(candidate, vehicle)
    if len(found) < 2:
        return None
    used = {i for i, _, _ in found[0].points}
    idle = [i for i in range(len(found[0].start)) if i not in used]
    return idle[0] if len(idle) == 1 and found[0].points else None


def swung(now: Linear, known: Sequence[Candidate]) -> Linear:
    """The same model with the best linearisation of each effect that has a shape in place of its own."""
    more: dict[str, list[Variant]] = {}
    for candidate in known:
        shape = shape_of(candidate, now.observation.vehicle)
        best = None if shape is None else _scanned(now, candidate, shape)
        if best is not None:
            more[candidate.label] = [best]
    if not more:
        return now
    found = linearised(now.observation, now.point, known, more, like=now)
    # Weighed anew: where a column appears that explains an axis, its error is noise no more. What healthy flights leave
    # unexplained stays noise.
    return found if now.observation.healthy is not None else found.weighed_beside()


def _scanned(now: Linear, candidate: Candidate, shape: int) -> Variant | None:
    o = now.observation
    own = variants(candidate, o.vehicle)
    at = places(candidate, o.vehicle)
    starts = [v.start[shape] for v in own]
    low, high = max(at[shape].low, _SPAN[0] * min(starts)), min(at[shape].high, _SPAN[1] * max(starts))
    values = np.geomspace(low, high, 1 + int(np.ceil(np.log(high / low) / np.log(_RATIO))))
    number = int(np.argmax([min(np.ptp(s.flight.t), _LONGEST) for s in o.samples]))
    s, turns = o.samples[number], o.transforms[number]
    until = s.flight.t[0] + _LONGEST
    before = s.residual(o.model(now.point))
    beside = [m for m in now.point if m.candidate.label != candidate.label]
    others = [i for i, c in enumerate(now.columns) if c.candidate.label != candidate.label]
    parts = [(k, p) for k, p in enumerate(now.found) if p.flight == number]
    rows = [p.time < until for _, p in parts]
    # What nothing explains yet counts as noise here, but not for unpredictable.
    weight = [np.sqrt(now.weights.certain(k, p))[r] for (k, p), r in zip(parts, rows, strict=True)]
    fixed = np.concatenate(
        [
            p.values[np.ix_(r, [0, *(1 + i for i in others)])] * w[:, None]
            for (_, p), r, w in zip(parts, rows, weight, strict=True)
        ]
    )
    spike = np.sqrt(np.diag(now.prior(Scales(1.0))))[others]
    deviation = np.where(spike > 0, spike, SLAB)
    others_gram = cho_factor(fixed[:, 1:].T @ fixed[:, 1:] + np.diag(deviation**-2.0))
    rest = fixed[:, 0] - fixed[:, 1:] @ cho_solve(others_gram, fixed[:, 1:].T @ fixed[:, 0])

    def gain(value: float) -> float:
        start = own[0].start.copy()
        for i, _, size in own[0].points:
            start[i] += size
        start[shape] = value
        try:
            after = s.residual(o.model([*beside, Member(candidate, written(candidate, at, start))]))
        except InputError:
            return 0.0
        of_one = spectra([s], [turns], binned([turns], [[b - a for a, b in zip(after, before, strict=True)]]))
        x = np.concatenate([p.values[r, 0] * w for p, r, w in zip(of_one, rows, weight, strict=True)])
        # A swing that no flight has may overflow.
        with np.errstate(over="ignore", invalid="ignore"):
            left = x - fixed[:, 1:] @ cho_solve(others_gram, fixed[:, 1:].T @ x, check_finite=False)
            along, size = left @ rest, left @ x
            found = along * max(along, 0.0) / size if size > 0 else 0.0
        return float(found) if np.isfinite(found) else 0.0

    gains = np.array([gain(v) for v in values])
    best = int(np.argmax(gains))
    if gains[best] <= 0:
        return None
    from scipy.optimize import minimize_scalar  # late: few flights have a load to look for

    # A step of the grid off, a swing is out of phase before long, and what is found with it is not its own.
    near = (values[max(best - 1, 0)], values[min(best + 1, len(values) - 1)])
    refined = minimize_scalar(lambda v: -gain(v), bounds=near, method="bounded", options={"xatol": _EXACT * near[0]})
    value = float(refined.x) if -refined.fun > gains[best] else float(values[best])
    return _variant(candidate, at, own[0], value, o.vehicle, shape)


def _variant(candidate: Candidate, at, like: Variant, value: float, vehicle, shape: int) -> Variant:
    absent = read(candidate.absent(vehicle), at)
    start: Array = like.start.copy()
    start[shape] = value
    points = []
    for i, _, size in like.points:
        x = np.where(np.arange(len(absent)) == shape, value, absent)
        x[i] = absent[i] + size
        points.append((i, written(candidate, at, x), size))
    return replace(like, points=tuple(points), start=start)
