"""The informative cost of a candidate (eq. 13, 18): the posterior variance left over the region after flying it.

The variance depends on where data are taken, not on their values, so simulated inputs suffice; hyperparameters are kept
(our reading of step 3). What would be learned from a flight is a k-medoids subset of it, so that is what is added.

The paper's cost counts every measurement alike. But a residual that depends on the command alone cannot hold what the
actuators do dynamically: if their response is off by `response_time`, a torque that changes at the rate du/dt leaves an
error of response_time du/dt, which is noise to the model. A flight that shakes the vehicle teaches less than its inputs
promise. With `response_time` the added points carry that variance; 0 is the paper's cost.
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
    many are learned from a flight; response_time: s, by which the declared response of the actuators may be off;
    period: s between the rows of the flights.
    """

    processes: tuple[GaussianProcess, ...]
    region: Array
    points: int
    threads: int = 1
    response_time: float = 0.0
    period: float = 0.01

    def costs(self, commands: Array, rng: np.random.Generator) -> Array:
        """Cost of each simulated flight, (references, draws), (rad/s^2)^2: mean over the region, sum of outputs.

        commands: (references, draws, n, d), scaled wrenches. A mean instead of the sum of eq. 13 leaves the order as
        it is and makes regions of different size comparable.
        """
        step = max(1, commands.shape[2] // _THINNED)
        flights = commands[:, :, ::step].reshape(-1, *commands[0, 0, ::step].shape)
        noise = np.repeat(self._dynamic_noise(commands[:, :, ::step], step * self.period), commands.shape[1])
        jobs = list(zip(flights, rng.spawn(len(flights)), noise, strict=True))

        def part(start: int) -> list[float]:
            variances = [RegionVariance(process, self.region) for process in self.processes]
            return [self._cost(*job, variances) for job in jobs[start :: self.threads]]

        result = np.empty(len(jobs))
        with ThreadPoolExecutor(self.threads) as pool:
            for start, costs in enumerate(pool.map(part, range(self.threads))):
                result[start :: self.threads] = costs
        return result.reshape(commands.shape[:2])

    def _cost(self, flight: Array, rng: np.random.Generator, noise: float, variances: list[RegionVariance]) -> float:
        added = flight[k_medoids(flight, self.points, rng)]
        return float(np.mean([np.sum(v.sum_after(added, noise)) for v in variances])) / len(self.region)

    def _dynamic_noise(self, commands: Array, step: float) -> Array:
        """Variance (references,) that an undeclared response time leaves: its square times that of the torque's rate.

        The mean over the draws is differentiated, so that the estimate's noise does not count as motion.
        """
        torque = commands[..., 3:].mean(axis=1)
        rate = np.gradient(torque, step, axis=1)
        return self.response_time**2 * np.mean(np.sum(rate**2, axis=-1), axis=-1)
