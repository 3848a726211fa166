"""Numbers that are alike, as those of rotors are, each held against the mean of the others."""

from __future__ import annotations

import numpy as np

from infotraj.rotations import Array


def beside_others(x: Array, covariance: Array) -> tuple[Array, Array]:
    """How far each of x (n,) lies from the mean of the others, (n,), and its standard error, (n,).

    covariance: (n, n), what is not known of x: what is not known of all alike takes nothing from one beside the others.
    One number alone is as far off as it is large.
    """
    n = len(x)
    apart = np.full((n, n), -1.0 / max(n - 1, 1))
    np.fill_diagonal(apart, 1.0)
    return apart @ x, np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", apart, covariance, apart), 0.0))
