"""Closed-loop simulation of references with draws of the residual (eq. 12, 14), all rollouts batched. Compiled.

The simulated robot is h + g' of eq. 19: a rigid body that receives the commanded wrench plus g'(u), g' being either
one consistent draw of the posterior for the whole flight or, as the paper's words may also be read, a fresh marginal
draw at every step. The controller is the one that flies, with mu, and sees the state with the estimator's noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from infotraj.control.demand import demand, rotate_into
from infotraj.control.gains import Gains
from infotraj.control.inversion import invert
from infotraj.control.tracking import no_residual, states
from infotraj.dynamics import rigid_body
from infotraj.residual.compiled import draw_value, marginal_value
from infotraj.residual.draws import MarginalDraws, PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle


class EstimateNoise(NamedTuple):
    """Standard deviation of the estimate's white error: m, rad, m/s, rad/s."""

    position: float = 0.0
    attitude: float = 0.0
    velocity: float = 0.0
    rate: float = 0.0


class Simulator:
    """Simulates references for one vehicle, one controller and one posterior; every call is batched.

    `process` is the model that the controller inverts; `draws` are the robots it may meet.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        process: GaussianProcess | None,
        gains: Gains | None = None,
        noise: EstimateNoise | None = None,
        threads: int = 1,
    ) -> None:
        self._vehicle = vehicle
        self._process = process or no_residual()
        self._gains = gains or Gains()
        self._noise = noise or EstimateNoise()
        self._threads = threads

    def commands(
        self, references: list[Reference], draws: PosteriorDraws | MarginalDraws, rng: np.random.Generator
    ) -> Array:
        """Commanded wrenches, scaled by mass and inertia (m/s^2, rad/s^2): (references, draws, n, 6).

        The references share one time grid of n samples. The noise of draw k is the same for every reference, so that
        candidates differ by what they are and not by their luck.
        """
        return self._simulate(references, draws, rng, keep_states=False)[0]

    def rollout(self, reference: Reference, draws: PosteriorDraws, rng: np.random.Generator) -> tuple[Array, Array]:
        """Commands (draws, n, 6) and states (draws, n, 13) of one reference: position, attitude, velocity, rate."""
        commands, moved = self._simulate([reference], draws, rng, keep_states=True)
        return commands[0], moved[0]

    def _simulate(
        self,
        references: list[Reference],
        draws: PosteriorDraws | MarginalDraws,
        rng: np.random.Generator,
        keep_states: bool,
    ) -> tuple[Array, Array]:
        count, samples = draws.count, len(references[0].t)
        spread = np.repeat(np.asarray(self._noise, dtype=np.float32), 3)
        noise = spread * rng.standard_normal((count, samples, 12), dtype=np.float32)
        rows = [states(reference) for reference in references]
        out = np.empty((len(references), count, samples, 6))
        moved = np.empty((len(references), count, samples if keep_states else 0, 13))
        jobs = [(i, k) for i in range(len(references)) for k in range(count)]
        inertia = self._vehicle.inertia_matrix()
        inverse = np.linalg.inv(inertia)
        scale = rigid_body.scale(self._vehicle)
        gains, gravity, process = self._gains, self._vehicle.gravity, self._process.mean_arrays
        period = references[0].dt
        if isinstance(draws, PosteriorDraws):
            step: Any = _rollout
            arrays: Sequence[tuple[Any, ...]] = [draws.one(k) for k in range(count)]
        else:
            fresh = draws.rng.standard_normal((count, samples, 3))
            step, arrays = _marginal_rollout, [(*draws.arrays, fresh[k]) for k in range(count)]

        def run(job: tuple[int, int]) -> None:
            i, k = job
            step(
                gains,
                gravity,
                inertia,
                inverse,
                scale,
                period,
                rows[i],
                noise[k],
                process,
                arrays[k],
                out[i, k],
                moved[i, k],
            )

        if self._threads == 1:
            for job in jobs:
                run(job)
        else:
            run(jobs[0])
            with ThreadPoolExecutor(self._threads) as pool:
                list(pool.map(run, jobs[1:], chunksize=4))
        return out, moved


@njit(cache=True, nogil=True)
def _rollout(gains, gravity, inertia, inverse, scale, period, reference, noise, process, draw, out, moved):
    state = reference[0, :13].copy()
    memory = np.zeros(9)
    residual = np.empty(3)
    frequencies, phases, amplitudes, update, points, weights, variance, constant, slopes = draw
    for k in range(reference.shape[0]):
        if moved.shape[0]:
            moved[k] = state
        _command(gains, gravity, inertia, period, state, reference[k], noise[k], process, memory, out[k])
        draw_value(
            out[k], frequencies, phases, amplitudes, update, points, weights, variance, constant, slopes, residual
        )
        _advance(state, out[k], residual, gravity, inertia, inverse, scale, period)


@njit(cache=True, nogil=True)
def _marginal_rollout(gains, gravity, inertia, inverse, scale, period, reference, noise, process, draw, out, moved):
    state = reference[0, :13].copy()
    memory = np.zeros(9)
    residual = np.empty(3)
    points, alpha, factor, weights, variance, mean, normal = draw
    scratch = np.empty(points.shape[1])
    for k in range(reference.shape[0]):
        if moved.shape[0]:
            moved[k] = state
        _command(gains, gravity, inertia, period, state, reference[k], noise[k], process, memory, out[k])
        marginal_value(out[k], points, alpha, factor, weights, variance, mean, normal[k], scratch, residual)
        _advance(state, out[k], residual, gravity, inertia, inverse, scale, period)


@njit(cache=True, nogil=True)
def _command(gains, gravity, inertia, period, state, reference, noise, process, memory, out):
    """The controller's command for a noisy estimate; memory holds its integrals (6) and last correction (3)."""
    estimate, wanted = np.empty(13), np.empty(6)
    _observe(state, noise, estimate)
    demand(gains, gravity, inertia, period, estimate, reference, memory[:6], wanted)
    invert(wanted, process, gains.max_correction, memory[6:], out)


@njit(cache=True, nogil=True)
def _observe(state, noise, estimate):
    for i in range(3):
        estimate[i] = state[i] + noise[i]
        estimate[7 + i] = state[7 + i] + noise[6 + i]
        estimate[10 + i] = state[10 + i] + noise[9 + i]
    _turn(state[3:7], noise[3:6], estimate[3:7])


@njit(cache=True, nogil=True)
def _turn(q, rotvec, out):
    """out = q exp(rotvec), second order in the half angle and normalised; the angles are below 0.1 rad."""
    x, y, z = 0.5 * rotvec[0], 0.5 * rotvec[1], 0.5 * rotvec[2]
    w = 1.0 - 0.5 * (x * x + y * y + z * z)
    a = w * q[0] - x * q[1] - y * q[2] - z * q[3]
    b = w * q[1] + x * q[0] + z * q[2] - y * q[3]
    c = w * q[2] + y * q[0] + x * q[3] - z * q[1]
    d = w * q[3] + z * q[0] + y * q[1] - x * q[2]
    norm = np.sqrt(a * a + b * b + c * c + d * d)
    out[0], out[1], out[2], out[3] = a / norm, b / norm, c / norm, d / norm


@njit(cache=True, nogil=True)
def _advance(state, command, residual, gravity, inertia, inverse, scale, period):
    """One period by the midpoint rule for the attitude and Heun-like averages for the rest (second order)."""
    w = state[10:13].copy()
    torque = np.empty(3)
    for i in range(3):
        torque[i] = scale[3 + i] * (command[3 + i] + residual[i])
    alpha = _angular(torque, w, inertia, inverse)
    middle = w + 0.5 * period * alpha
    alpha = _angular(torque, middle, inertia, inverse)
    half, turned = np.empty(4), np.empty(4)
    _turn(state[3:7], 0.5 * period * (w + 0.25 * period * alpha), half)
    # R f for the attitude in the middle of the step
    back = np.array([half[0], -half[1], -half[2], -half[3]])
    acceleration = np.empty(3)
    rotate_into(back, command[:3], acceleration)
    acceleration[2] -= gravity
    _turn(state[3:7], period * middle, turned)
    for i in range(3):
        state[i] += period * (state[7 + i] + 0.5 * period * acceleration[i])
        state[7 + i] += period * acceleration[i]
        state[10 + i] = w[i] + period * alpha[i]
    state[3:7] = turned


@njit(cache=True, nogil=True)
def _angular(torque, w, inertia, inverse):
    m = inertia @ w
    net = np.array(
        [
            torque[0] - (w[1] * m[2] - w[2] * m[1]),
            torque[1] - (w[2] * m[0] - w[0] * m[2]),
            torque[2] - (w[0] * m[1] - w[1] * m[0]),
        ]
    )
    return inverse @ net
