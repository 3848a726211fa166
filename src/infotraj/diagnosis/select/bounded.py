"""The numbers of sets of columns beside their slabs, held at the bounds that a fit drives them beyond; compiled.

A search asks for thousands of sets of a few columns each.
"""

from __future__ import annotations

import numpy as np
from numba import njit

PASSES = 4  # rounds of holding numbers at the bounds that they go beyond
_SURE = 3.0  # standard errors within which a number may lie beyond a bound


@njit(cache=True, error_model="numpy")
def densities(gram, right, slab, low, high, columns, starts):
    """Log density (n,) of sets of columns, relative to the set without any.

    gram (p, p), right (p,): products of all columns; slab, low, high (p,): deviation and bounds of each number; set k
    has the columns `columns[starts[k]:starts[k + 1]]` (whole numbers). -inf where no number of a set is left free, and
    where its columns cannot be told apart.
    """
    out = np.empty(len(starts) - 1)
    for k in range(len(out)):
        own = columns[starts[k] : starts[k + 1]]
        if len(own) == 0:
            out[k] = 0.0
            continue
        held, at = bounded(gram, right, slab, low, high, own)
        out[k] = -np.inf
        if held.all():
            continue
        fixed = 0.0
        for i in range(len(own)):
            if held[i]:
                fixed += at[i] * right[own[i]]
                for j in range(len(own)):
                    if held[j]:
                        fixed -= 0.5 * at[i] * gram[own[i], own[j]] * at[j]
        theta, _, size, pull = _free(gram, right, slab, own, held, at, False)
        value = fixed + 0.5 * (np.sum(theta * pull) - size)
        if np.isfinite(value):
            out[k] = value
    return out


@njit(cache=True, error_model="numpy")
def bounded(gram, right, slab, low, high, own):
    """Whether each number of the columns `own` (q,) is held at a bound, (q,) bool, and at which, (q,), else 0."""
    held, at = np.zeros(len(own), dtype=np.bool_), np.zeros(len(own))
    for _ in range(PASSES):
        theta, error, _, _ = _free(gram, right, slab, own, held, at, True)
        more, place = False, 0
        was = held.copy()
        for i in range(len(own)):
            if was[i]:
                continue
            x, e, c = theta[place], error[place], own[i]
            place += 1
            if x < low[c] - _SURE * e or x > high[c] + _SURE * e:
                held[i], at[i], more = True, low[c] if x < low[c] else high[c], True
        if not more or held.all():
            break
    return held, at


@njit(cache=True, error_model="numpy")
def _free(gram, right, slab, own, held, at, errors):
    """The numbers (f,) that are not held, their errors (f,), the size of their system (log), and its right side (f,).

    errors: whether they are asked for; 0 else. By Cholesky's method without roots, scaled to a diagonal of ones: of a
    system that is singular but for rounding it takes no root. NaN or infinite where a pivot is 0.
    """
    count = 0
    for i in range(len(own)):
        count += not held[i]
    index, pull = np.empty(count, dtype=np.int64), np.empty(count)
    place = 0
    for i in range(len(own)):
        if held[i]:
            continue
        index[place], pull[place] = own[i], right[own[i]]
        for j in range(len(own)):
            if held[j]:
                pull[place] -= gram[own[i], own[j]] * at[j]
        place += 1
    lower, scale, pivot = np.eye(count), np.empty(count), np.empty(count)
    size = 0.0
    for i in range(count):
        c = index[i]
        scale[i] = 1.0 / np.sqrt(abs(gram[c, c] + 1.0 / slab[c] ** 2))
        size += 2.0 * np.log(slab[c]) - 2.0 * np.log(scale[i])
    for i in range(count):
        for j in range(i + 1):
            x = gram[index[i], index[j]] * scale[i] * scale[j]
            if i == j:
                x += (scale[i] / slab[index[i]]) ** 2
            for k in range(j):
                x -= lower[i, k] * pivot[k] * lower[j, k]
            if i == j:
                pivot[i] = x
            else:
                lower[i, j] = x / pivot[j]
        size += np.log(abs(pivot[i]))
    theta, error = np.empty(count), np.zeros(count)
    column = np.empty(count)
    for n in range(count + 1 if errors else 1):  # the right side, then each column of the inverse
        for i in range(count):
            column[i] = pull[i] * scale[i] if n == 0 else 1.0 if i == n - 1 else 0.0
            for k in range(i):
                column[i] -= lower[i, k] * column[k]
        for i in range(count):
            column[i] /= pivot[i]
        for i in range(count - 1, -1, -1):
            for k in range(i + 1, count):
                column[i] -= lower[k, i] * column[k]
        if n == 0:
            theta[:] = column * scale
        else:
            error[n - 1] = np.sqrt(max(column[n - 1], 0.0)) * scale[n - 1]
    return theta, error, size, pull
