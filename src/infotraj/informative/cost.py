"""The informative cost of a candidate (eq. 13, 18): the posterior variance left over the region after flying it.

The variance depends on where data are taken, not on their values, so simulated inputs suffice; hyperparameters are kept
(our reading of step 3).

Which process scores is a choice of its own. The paper scores with the model that will fly, whose lengthscales were
fitted, one an input, to the points of one flight. `of_one_lengthscale` scores with one length for all inputs: a flight
that held an input still says nothing of how the residual depends on it, and the fit then gives that input a long
lengthscale, so that the flight that shakes most looks best (docs/study.md).
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.posterior_variance import RegionVariance
from infotraj.rotations import Array

_THINNED = 400  # rows of a simulated flight that the subset is chosen from: 50 ms apart in 20 s

Subset = Callable[[Array, int, np.random.Generator], NDArray[np.int64]]


def of_one_lengthscale(prior: GaussianProcess, lengthscale: float, noise: float) -> GaussianProcess:
    """The points of `prior` under a kernel of one lengthscale (m/s^2 and rad/s^2) for all inputs; noise in rad/s^2.

    Signal variance 1 (rad/s^2)^2 and one output. The three outputs share their inputs, so with one kernel they differ
    by a factor alone, which a fit to a still flight gets wrong like the lengthscales.
    """
    lengths = np.full((1, prior.d), lengthscale)
    return GaussianProcess(prior.X, np.zeros((prior.n, 1)), lengths, np.ones(1), np.full(1, noise**2), np.zeros(1))


@dataclass(frozen=True)
class Scorer:
    """Scores simulated flights against a region (r, d) for a process that holds the prior points.

    points: how many of a flight are added; subset: which, of the rows of its inputs.
    """

    process: GaussianProcess
    region: Array
    points: int
    subset: Subset
    threads: int = 1

    def costs(self, commands: Array, rng: np.random.Generator) -> Array:
        """Cost of each simulated flight, (references, draws), (rad/s^2)^2: mean over the region, sum of outputs.

        commands: (references, draws, n, d), scaled wrenches. A mean instead of the sum of eq. 13 leaves the order as
        it is and makes regions of different size comparable.
        """
        thinned = commands[:, :, :: max(1, commands.shape[2] // _THINNED)]
        flights = thinned.reshape(-1, *thinned.shape[2:])
        jobs = list(zip(flights, rng.spawn(len(flights)), strict=True))

        def part(start: int) -> list[float]:
            variance = RegionVariance(self.process, self.region)
            return [self._cost(*job, variance) for job in jobs[start :: self.threads]]

        result = np.empty(len(jobs))
        with ThreadPoolExecutor(self.threads) as pool:
            for start, costs in enumerate(pool.map(part, range(self.threads))):
                result[start :: self.threads] = costs
        return result.reshape(commands.shape[:2])

    def _cost(self, flight: Array, rng: np.random.Generator, variance: RegionVariance) -> float:
        added = flight[self.subset(flight, self.points, rng)]
        return float(np.sum(variance.sum_after(added))) / len(self.region)
