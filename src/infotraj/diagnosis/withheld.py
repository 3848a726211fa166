"""Error that effects take up that are not named: no supported effect explains it, so it is unexplained."""

from __future__ import annotations

from collections.abc import Mapping, Set

import numpy as np

from infotraj.diagnosis.fitting import Fit
from infotraj.diagnosis.formula import Misfit
from infotraj.diagnosis.refusal import axis_group
from infotraj.diagnosis.search import Search, rises
from infotraj.diagnosis.unexplained import Structure

_SMALL = 0.003  # of what the named effects explain on an axis: their formulas are hardly exact to better than 5 %


def withheld(
    search: Search,
    whole: Fit,
    named: Set[str],
    misfits: Mapping[str, Misfit],
    chance: float,
    refused: Mapping[str, str],
) -> list[Structure]:
    """What the members of the fitted model take up that have no name.

    named: labels of members that are supported or within tolerance; misfits: of members by label; chance: gain that an
    absent effect gets; refused: axes on which nothing can be said, and why. What several members take up together may
    matter where none of them does.
    """
    taken = [
        Structure(x.axis, float("nan"), 0.0, x.rise, (), f"{label} fits it with numbers that change {x.how}", x.share)
        for label, x in misfits.items()
        if axis_group(x.axis) not in refused
    ]
    others = [m.candidate.label for m in whole.members if not m.held and m.candidate.label not in named]
    without = search.fitted([m for m in whole.members if m.candidate.label not in others])
    given = search.fitted([m for m in whole.members if m.held])
    if taken or not others or without is None or given is None or without.cost - whole.cost < chance:
        return taken
    rise = rises(whole, without)
    matters = np.maximum(search.matters, _SMALL * rises(whole, given))
    axis = int(np.argmax(rise / matters))
    if rise[axis] <= matters[axis] or axis_group(whole.sums.axes[axis]) in refused:
        return []
    hint = f"{' and '.join(others)} take{'' if len(others) > 1 else 's'} it up, without sufficient evidence"
    return [Structure(whole.sums.axes[axis], float("nan"), 0.0, float(rise[axis]), (), hint, 0.0)]
