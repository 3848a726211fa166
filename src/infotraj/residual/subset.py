"""Few points out of a flight's many rows: k-medoids on the inputs with squared Euclidean distance, as the paper, which
follow how often the flight is where; or farthest-first traversal, which covers all that it reached.

Source of the first: E. Schubert and P. J. Rousseeuw, "Fast and eager k-medoids clustering" (Information Systems 101,
2021), the `kmedoids` package; started from the points nearest to k-means centres, which lie close to the medoids of
this distance. Of the second: T. F. Gonzalez, "Clustering to minimize the maximum intercluster distance" (1985).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from infotraj.errors import problem
from infotraj.rotations import Array

LARGEST = 4000  # rows that are clustered; their distances take 64 MB


def k_medoids(X: ArrayLike, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Indices, ascending, (min(count, n),), of rows of X (n, d) that represent the others; X in comparable units.

    More than 4000 rows are thinned first to 4000 at equal steps of the row number: rows are samples in time, and
    neighbours in time are neighbours in X. Where X has fewer distinct rows than count, one of each is taken and rows
    that repeat fill up, because a repeated measurement still averages noise. ValueError where X is not finite.
    """
    X = np.asarray(X, dtype=float)
    if X.ndim != 2 or count < 0 or not np.isfinite(X).all():
        raise ValueError(
            problem(f"{count} medoids of an array {X.shape}", "count >= 0 of a finite (n, d) array", "Drop NaN rows.")
        )
    n = len(X)
    if count >= n or count == 0:
        return np.arange(min(count, n))
    kept = np.arange(n)
    if n > LARGEST:
        kept = np.linspace(0, n - 1, max(LARGEST, count)).round().astype(np.int64)
    return kept[_cluster(X[kept], count, rng)]


def farthest_first(X: ArrayLike, count: int) -> NDArray[np.int64]:
    """Indices, in the order of choice, (min(count, n),), of rows of X (n, d), each the farthest from those before it.

    The first is the row nearest to the mean. The distance of any row to the nearest of them is at most twice what the
    best choice of so many rows could reach. ValueError where X is not finite.
    """
    X = np.asarray(X, dtype=float)
    if X.ndim != 2 or count < 0 or not np.isfinite(X).all():
        raise ValueError(
            problem(f"{count} rows of an array {X.shape}", "count >= 0 of a finite (n, d) array", "Drop NaN rows.")
        )
    chosen = np.empty(min(count, len(X)), dtype=np.int64)
    nearest = np.full(len(X), np.inf)
    following = int(np.argmin(np.sum((X - X.mean(axis=0)) ** 2, axis=1))) if len(X) else 0
    for k in range(len(chosen)):
        chosen[k] = following
        nearest = np.minimum(nearest, np.sum((X - X[following]) ** 2, axis=1))
        following = int(np.argmax(nearest))
    return chosen


def _cluster(X: Array, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    distinct = np.unique(X, axis=0, return_index=True)[1]
    if len(distinct) <= count:
        return _filled(distinct, count, len(X), rng)
    from kmedoids import fasterpam  # late: with scikit-learn 0.5 s, and only this stage needs them

    centred = (X - X.mean(axis=0)).astype(np.float32)
    squares = np.einsum("nd,nd->n", centred, centred)
    distances = centred @ centred.T
    distances *= -2.0
    distances += squares
    distances += squares[:, None]
    np.maximum(distances, 0.0, out=distances)
    seed = int(rng.integers(2**31))
    start = _filled(_nearest_to_centres(centred, distinct, count, seed), count, len(X), rng)
    found = fasterpam(distances, start.astype(np.uint64), n_cpu=1).medoids
    return np.sort(np.asarray(found, dtype=np.int64))


def _nearest_to_centres(
    X: NDArray[np.float32], distinct: NDArray[np.int64], count: int, seed: int
) -> NDArray[np.int64]:
    from sklearn.cluster import KMeans

    # One start of ten iterations is enough: fasterpam improves it, and its own cost falls with the start's quality.
    centres = KMeans(count, n_init=1, max_iter=10, random_state=seed).fit(X).cluster_centers_
    candidates = X[distinct]
    squares = np.einsum("nd,nd->n", candidates, candidates)
    return np.unique(distinct[np.argmin(squares - 2.0 * centres @ candidates.T, axis=1)])


def _filled(chosen: NDArray[np.int64], count: int, n: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """`chosen` and enough other indices at random to make `count`, ascending."""
    others = np.setdiff1d(np.arange(n), chosen)
    return np.sort(np.concatenate([chosen, rng.permutation(others)[: count - len(chosen)]]))
