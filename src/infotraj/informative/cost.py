"""The informative cost of a candidate (eq. 13, 18): the posterior variance left over the region after flying it.

The variance depends on where data are taken, not on their values, so simulated inputs suffice; hyperparameters are kept
(our reading of step 3). What would be learned from a flight is a k-medoids subset of it, so that is what is added.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.posterior_variance import RegionVariance
from infotraj.residual.subset import k_medoids
from infotraj.rotations import Array

_THINNED = 400  # rows of a simulated flight that the subset is chosen from: 50 ms apart in 20 s


@dataclass(frozen=True)
class Scorer:
    """Scores simulated flights against a region (r, d) for one or several models of the same data.

    processes: the model, or several with hyperparameters from their posterior, whose costs are averaged; points: how
    many are learned from a flight.
    """

    processes: tuple[GaussianProcess, ...]
    region: Array
    points: int
    threads: int = 1

    def costs(self, commands: Array, rng: np.random.Generator) -> Array:
        """Cost of each simulated flight, (references, draws), (rad/s^2)^2: mean over the region, sum of outputs.

        commands: (references, draws, n, d), scaled wrenches. A mean instead of the sum of eq. 13 leaves the order as
        it is and makes regions of different size comparable.
        """
        step = max(1, commands.shape[2] // _THINNED)
        flights = commands[:, :, ::step].reshape(-1, *commands[0, 0, ::step].shape)
        jobs = list(zip(flights, rng.spawn(len(flights)), strict=True))

        def part(start: int) -> list[float]:
            variances = [RegionVariance(process, self.region) for process in self.processes]
            return [self._cost(flight, own, variances) for flight, own in jobs[start :: self.threads]]

        result = np.empty(len(jobs))
        with ThreadPoolExecutor(self.threads) as pool:
            for start, costs in enumerate(pool.map(part, range(self.threads))):
                result[start :: self.threads] = costs
        return result.reshape(commands.shape[:2])

    def _cost(self, flight: Array, rng: np.random.Generator, variances: list[RegionVariance]) -> float:
        added = flight[k_medoids(flight, self.points, rng)]
        return float(np.mean([np.sum(v.sum_after(added)) for v in variances])) / len(self.region)
