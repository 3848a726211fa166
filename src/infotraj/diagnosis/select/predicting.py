"""How large errors are on flights that a model was not fitted to, as the model itself has them.

Every fold under the numbers that were fitted without it. The model is computed as it is, not made linear: a product of
what the file is off by and an effect may be as large as either.
"""

from __future__ import annotations

import numpy as np

from infotraj.diagnosis.noise.spectra import EDGES, binned, spectra
from infotraj.diagnosis.select.fit import Fit
from infotraj.rotations import Array

TELLS = float(np.log(1.2))  # by which errors on flights not fitted fall for what is told: a sixth of one axis
_MOSTLY = 2.0  # in units of its noise: of a squared error that is larger most is something else


def left(made: Fit, each: Array | None, weighted: bool = False) -> Array:
    """Mean square (axes,) of the slow coefficients of every fold under the numbers that were fitted without it.

    each (folds, p); None: the model as given. weighted: of all coefficients, in units of their noise: 1 where a model
    leaves no more than the richest one does.
    """
    linear, o = made.linear, made.linear.observation
    axes = linear.sums.axes
    total, count = np.zeros(len(axes)), np.zeros(len(axes))
    folds = [None] if each is None else list(np.unique(o.blocks.fold))
    for k, fold in enumerate(folds):
        members = [m for m in linear.point if m.held] if made.held is None else list(made.held)
        if each is not None:
            members = list(linear.members(made.chosen, each[k], shift=np.inf))
        model = o.model(members)
        for number, (samples, turns) in enumerate(zip(o.samples, o.transforms, strict=True)):
            if fold is not None and fold not in o.blocks.fold[o.blocks.flight == number]:
                continue
            raw = o.of_flight(number).raw(model)
            if raw is None:
                return np.full(len(axes), np.inf)
            before = 3 * sum(len(x.channels) for x in o.samples[:number])
            for place, s in enumerate(spectra([samples], [turns], binned([turns], raw)), before):
                own = s.band < (len(EDGES) if weighted else linear.weights.slow(s.axis))
                if fold is not None:
                    own &= o.blocks.fold[o.blocks.at(number, s.time)] == fold
                a = axes.index(s.axis)
                weight = linear.weights.of(place, s)[own] if weighted else np.ones(own.sum())
                total[a] += np.sum(weight * s.values[own, 0] ** 2)
                count[a] += np.sum(weight * linear.weights.noise[a, s.band[own]]) if weighted else own.sum()
    return total / np.where(count > 0.0, count, 1.0)


def fall(plain: Array, weighted: Array, stays: Array) -> Array:
    """By which logarithm each error falls that does so by `plain` as it is and by `weighted` in units of its noise.

    By what is more: where frames vibrate or poses are differenced nearly all of an error is noise, of which nothing
    takes anything off. One that gets worse as it is has that taken off. Only `plain` counts where less than half of
    what is left is noise (`stays`, in units of its noise): what resembles physics without a name is sure there, however
    little it moves the vehicle.
    """
    more = np.maximum(weighted - np.maximum(plain, 0.0), 0.0)
    return plain + np.where(stays <= _MOSTLY, more, 0.0)


def net(share: Array) -> float:
    """What a model does to all axes together: the sum of the logarithms of their errors' shares."""
    return float(np.sum(np.log(np.clip(share, 1e-6, 1e6)[share > 0])))
