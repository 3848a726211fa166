"""The region Z around the task where the model has to be good (eq. 10, 14, 15), in the space of commanded wrenches.

Eq. 15 keeps those of uniform samples that lie within epsilon of a point that a simulated task visited. That is a
uniform law on a union of balls; `uniform_region` samples it directly instead of rejecting nearly all of a box in six
dimensions (Karp, Luby and Madras 1989): a ball is drawn, a point in it, and the point kept with one over the number of
balls that hold it. `visited_region` is the alternative that we compare with it: the visited points themselves, so that
the cost weighs inputs by how often the task needs them.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from infotraj.errors import InfotrajError, problem
from infotraj.residual.draws import PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array

_CENTRES = 500  # balls; more only overlap: a task of 20 s visits a curve, not a volume


def epsilon(process: GaussianProcess, draws: PosteriorDraws, commands: Array) -> float:
    """Mean distance between the optimal and the nominal commands in simulation (Sec. V-A); m/s^2 and rad/s^2.

    commands (draws, n, 6): the nominal ones, u + mu(u) = d. The optimal ones solve u + g'(u) = d for the draw that was
    flown, here by fixed-point iteration from the nominal ones.
    """
    count, n, d = commands.shape
    demand = commands.copy()
    demand[..., 3:] += process.mean(commands.reshape(-1, d)).reshape(count, n, 3)
    optimal = commands.copy()
    for _ in range(10):
        optimal[..., 3:] = 0.5 * (optimal[..., 3:] + demand[..., 3:] - draws(optimal))
    return float(np.linalg.norm(optimal - commands, axis=-1).mean())


def uniform_region(visited: Array, radius: float, count: int, rng: np.random.Generator) -> Array:
    """`count` points (count, d), uniform in the union of balls of `radius` around visited points (n, d)."""
    centres = visited[rng.choice(len(visited), min(_CENTRES, len(visited)), replace=False)]
    tree = KDTree(centres)
    kept: list[Array] = []
    total = 0
    for _ in range(1000):
        direction = rng.standard_normal((4 * count, centres.shape[1]))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        distance = radius * rng.random((4 * count, 1)) ** (1.0 / centres.shape[1])
        points = centres[rng.integers(len(centres), size=4 * count)] + distance * direction
        holders = tree.query_ball_point(points, radius * (1 + 1e-12), return_length=True)
        points = points[rng.random(4 * count) * holders < 1.0]
        kept.append(points)
        total += len(points)
        if total >= count:
            return np.concatenate(kept)[:count]
    raise InfotrajError(
        problem(f"{total} of {count} points of the region found", "all of them", "Use a smaller epsilon.")
    )


def visited_region(visited: Array, count: int, rng: np.random.Generator) -> Array:
    """`count` of the visited points (n, d), drawn without replacement: weighted as the task visits them."""
    return visited[rng.choice(len(visited), min(count, len(visited)), replace=False)]
