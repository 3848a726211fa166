"""Scenario `pool`: which recorded flight teaches most about a task, judged before it is learned (eq. 13 to 18).

The task is a fast flight, the model starts from a slow one, the candidates are all other good flights. The cost of a
candidate sees inputs only; the error is that of the lateral specific force on the task once 40 points of the candidate
are learned. The settings and the reasons for them are in docs/pool.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from infotraj.datasets import location, nanobench
from infotraj.errors import InputError, UsageError, problem
from infotraj.evaluation import pool_choice
from infotraj.evaluation.lateral_force import GRAVITY, STEP, LateralForce, counted_rows, lateral_force, rms
from infotraj.informative.cost import of_one_lengthscale
from infotraj.residual import hyperparameters, subset
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.posterior_variance import RegionVariance
from infotraj.robots.pool import Pool
from infotraj.rotations import Array, to_body
from infotraj.trajectories.reference import Reference
from infotraj.writing import write_text

COLUMNS = ("task", "prior", "candidate", "seed", "cost", "error", "chosen", "error_before")
_STRICTER = "Without the candidates that follow the task's own trajectory."
ALL, OTHER_TRAJECTORIES = "all", "all, without the task's own trajectory"  # rows of the summary beside the tasks
NOISE = 0.1  # of the kernel of one lengthscale, whose signal is 1
LEAST_SPREAD = 1e-3  # share of the weight; less is below the resolution of a logged voltage


@dataclass(frozen=True)
class Settings:
    """How the pool is judged; every number was fixed before a cost was compared with an error (docs/pool.md).

    prior_points, added_points: k-medoids points of the slow flight and of a candidate. rows_between: of the 10 ms rows
    one in so many is used, for the filter of 0.3 s leaves no more in them. region: 'recorded' takes the task's inputs
    from its record, 'planned' from its set-points alone. fill: 'uniform' is eq. 14, 'visited' the visited inputs
    themselves. restarts: starts of the hyperparameter search. lengthscale: of the kernel that the cost is taken with,
    in scaled inputs, all alike (`informative.cost.of_one_lengthscale`); None: the prior model's own kernel.
    """

    prior_points: int = 20
    added_points: int = 40
    rows_between: int = 5
    region: str = "recorded"
    fill: str = "uniform"
    region_points: int = 500
    ard: bool = True
    restarts: int = 2
    lengthscale: float | None = None

    def __post_init__(self) -> None:
        for name, allowed in (("region", ("recorded", "planned")), ("fill", ("uniform", "visited"))):
            if getattr(self, name) not in allowed:
                raise UsageError(problem(f"pool: {name} '{getattr(self, name)}'", " or ".join(allowed), "Change it."))


@dataclass(frozen=True)
class Scale:
    """Makes the inputs of a Gaussian process of body velocity and thrust: (n, 4), dimensionless, known from the prior.

    One scale for the three velocity components (m/s), so that space has no preferred direction; the thrust as a
    share of the weight, less 1, over its own spread. `weight` is the mean thrust (V^2) of the prior flight: one that
    begins and ends at rest carries its weight on average.
    """

    velocity: float
    weight: float
    spread: float

    @classmethod
    def of(cls, prior: LateralForce) -> Scale:
        """The scale that the prior flight gives."""
        weight = float(prior.thrust.mean())
        spread = max(float(prior.thrust.std()) / weight, LEAST_SPREAD)
        return cls(float(np.sqrt(np.mean(prior.velocity**2))), weight, spread)

    def recorded(self, flown: LateralForce) -> Array:
        """Inputs (n, 4) of a recorded flight."""
        return self._inputs(flown.velocity, flown.thrust / self.weight)

    def planned(self, reference: Reference) -> Array:
        """Inputs (n, 4) that a vehicle without drag needs on the reference, at every sample of it."""
        load = np.linalg.norm(reference.acceleration + np.array([0.0, 0.0, GRAVITY]), axis=1) / GRAVITY
        return self._inputs(to_body(reference.attitude, reference.velocity), load)

    def _inputs(self, velocity: Array, load: Array) -> Array:
        return np.column_stack([velocity / self.velocity, (load - 1.0) / self.spread])


def region_around(visited: Array, epsilon: float, count: int, rng: np.random.Generator) -> Array:
    """Region Z of eq. 14: `count` uniform samples of input space within epsilon of any visited input (n, d)."""
    tree = cKDTree(visited)
    low, high = visited.min(axis=0) - epsilon, visited.max(axis=0) + epsilon
    kept: list[Array] = []
    found = 0
    while found < count:
        sample = rng.uniform(low, high, size=(20 * count, visited.shape[1]))
        near = sample[np.isfinite(tree.query(sample, distance_upper_bound=epsilon)[0])]
        kept.append(near)
        found += len(near)
    return np.concatenate(kept)[:count]


def evaluate_pool(*, data_dir: str | Path | None, table: str | Path, seeds: list[int], **settings: Any) -> None:
    """Writes the pool's table (CSV): a row a task, prior, candidate and seed; settings as in Settings.

    cost: posterior variance summed over the task's region. error: RMS on the task (m/s^2) with the candidate learned.
    error_before: with the prior alone. chosen: 1 for the candidate of least cost. InputError where the data are absent.
    """
    folder = location.dataset(nanobench.NAME, data_dir)
    pool = Pool({name: nanobench.read(path) for name, path in nanobench.good_flights(folder).items()})
    rows = judge(pool, seeds, Settings(**settings))
    write_text(rows.to_csv(index=False, float_format="%.8g"), table)


def judge(pool: Pool, seeds: list[int], settings: Settings) -> pd.DataFrame:
    """The pool's table for every fast flight as task and every slow flight as prior, columns COLUMNS."""
    measured = {name: lateral_force(pool.recorded[name]) for name in pool.names}
    tasks = [name for name in pool.names if nanobench.speed(name) == "fast"]
    priors = [name for name in pool.names if nanobench.speed(name) == "slow"]
    parts = [_from_prior(pool, measured, tasks, prior, seed, settings) for seed in seeds for prior in priors]
    return pd.concat(parts, ignore_index=True)[list(COLUMNS)]


def _from_prior(
    pool: Pool, measured: dict[str, LateralForce], tasks: list[str], prior: str, seed: int, settings: Settings
) -> pd.DataFrame:
    """Every task and candidate from one prior and seed; what a candidate teaches does not depend on the task."""
    scale = Scale.of(measured[prior])
    inputs = {name: scale.recorded(one) for name, one in measured.items()}
    start = _start(inputs[prior], measured[prior].force, settings, _generator(seed, prior))
    scoring = start if settings.lengthscale is None else of_one_lengthscale(start, settings.lengthscale, NOISE)
    epsilon = tracking_distance(pool.reference(prior), measured[prior], scale)
    points, models = {}, {}
    for name in measured:
        if name == prior:
            continue
        rng = _generator(seed, prior, name)
        rows = _medoids(inputs[name], settings.added_points, settings, rng)
        points[name] = inputs[name][rows]
        models[name] = _relearned(start, points[name], measured[name].force[rows], settings, rng)
    parts = []
    for task in tasks:
        visited = _visited(pool, inputs, task, scale, settings)
        rng = _generator(seed, prior, task, "region")
        variance = RegionVariance(scoring, _region(visited, epsilon, settings, rng))
        candidates = [name for name in points if name != task]
        part = pd.DataFrame(
            {"candidate": candidates, "cost": [variance.sum_after(points[c]).sum() for c in candidates]}
        )
        truth = measured[task].force
        part["error"] = [rms(models[c].mean(inputs[task]) - truth) for c in candidates]
        part["chosen"] = (np.arange(len(part)) == part["cost"].argmin()).astype(int)
        parts.append(part.assign(task=task, prior=prior, seed=seed, error_before=rms(start.mean(inputs[task]) - truth)))
    return pd.concat(parts, ignore_index=True)


def tracking_distance(reference: Reference, flown: LateralForce, scale: Scale) -> float:
    """epsilon of eq. 14: mean distance between the inputs flown and those that the reference asks for.

    The paper takes it from the simulated task; the pool has no simulator, the prior's flight is what is known.
    """
    rows = np.clip(np.round((flown.t - reference.t[0]) / STEP).astype(int), 0, len(reference.t) - 1)
    return float(np.linalg.norm(scale.recorded(flown) - scale.planned(reference)[rows], axis=1).mean())


def _visited(pool: Pool, inputs: dict[str, Array], task: str, scale: Scale, settings: Settings) -> Array:
    if settings.region == "recorded":
        return inputs[task][:: settings.rows_between]
    reference = pool.reference(task)
    high = counted_rows(reference.t, reference.position[:, 2], np.ones(len(reference.t), dtype=bool))
    return scale.planned(reference)[high][:: settings.rows_between]


def _region(visited: Array, epsilon: float, settings: Settings, rng: np.random.Generator) -> Array:
    if settings.fill == "uniform":
        return region_around(visited, epsilon, settings.region_points, rng)
    return visited[rng.permutation(len(visited))[: settings.region_points]]


def _medoids(inputs: Array, count: int, settings: Settings, rng: np.random.Generator) -> np.ndarray:
    """Rows of the k-medoids of every rows_between-th input."""
    return subset.k_medoids(inputs[:: settings.rows_between], count, rng) * settings.rows_between


def _start(inputs: Array, force: Array, settings: Settings, rng: np.random.Generator) -> GaussianProcess:
    rows = _medoids(inputs, settings.prior_points, settings, rng)
    return _fit(inputs[rows], force[rows], settings, rng)


def _relearned(
    start: GaussianProcess, points: Array, force: Array, settings: Settings, rng: np.random.Generator
) -> GaussianProcess:
    """Prior and candidate together, hyperparameters optimised again."""
    return _fit(np.concatenate([start.X, points]), np.concatenate([start.Y, force]), settings, rng)


def _fit(X: Array, Y: Array, settings: Settings, rng: np.random.Generator) -> GaussianProcess:
    # Each flight's mean is removed and the inputs are scaled already: scales of a subset would only add its chance.
    return hyperparameters.fit(
        X,
        Y,
        rng,
        restarts=settings.restarts,
        ard=settings.ard,
        input_scale=np.ones(X.shape[1]),
        prior_mean=np.zeros(Y.shape[1]),
    )


def _generator(seed: int, *names: str) -> np.random.Generator:
    """A stream for the named flights alone, so that a pool with one flight more leaves the others as they were."""
    return np.random.default_rng([seed, *(crc32(name.encode()) for name in names)])


def summarise_pool(*, table: str | Path, summary: str | Path, markdown: str | Path, seed: int = 0) -> None:
    """Writes what the choice gained: `summary` (CSV, a row a task, one of all, and one without the
    flights of the task's own trajectory) and `markdown` (tables, intervals).

    `seed` draws the bootstrap alone. InputError where `table` is not one that evaluate_pool wrote.
    """
    try:
        rows = pd.read_csv(table)
    except (OSError, ValueError) as error:
        raise InputError(problem(f"{table}: cannot be read ({error})", "a pool table", "Evaluate the pool.")) from error
    chosen = pool_choice.choices(rows)
    tasks = pool_choice.by_task(chosen)
    gains = pool_choice.overall(chosen, np.random.default_rng(seed))
    parts = [tasks, _mean_row(ALL, tasks, gains)]
    other = _other_shapes(rows)
    stricter = None
    if other.any() and not other.all():
        fewer = pool_choice.choices(pool_choice.choose_again(rows, other))
        stricter = pool_choice.overall(fewer, np.random.default_rng(seed))
        parts.append(_mean_row(OTHER_TRAJECTORIES, pool_choice.by_task(fewer), stricter))
    write_text(pd.concat(parts, ignore_index=True).to_csv(index=False, float_format="%.6g"), summary)
    write_text(_markdown(tasks, gains, stricter, chosen), markdown)


def _mean_row(name: str, tasks: pd.DataFrame, gains: pd.DataFrame) -> pd.DataFrame:
    """The mean over the tasks as a row of that name, with the intervals over the tasks."""
    mean = tasks.drop(columns="task").mean().to_frame().T.assign(task=name)
    for gain in gains.to_dict("records"):
        mean[f"low_{gain['against']}"], mean[f"high_{gain['against']}"] = gain["low"], gain["high"]
    return mean


def _other_shapes(rows: pd.DataFrame) -> np.ndarray:
    """Rows whose candidate follows another trajectory than the task, (n,)."""
    return rows["task"].map(nanobench.shape).to_numpy() != rows["candidate"].map(nanobench.shape).to_numpy()


def _markdown(tasks: pd.DataFrame, gains: pd.DataFrame, stricter: pd.DataFrame | None, chosen: pd.DataFrame) -> str:
    count = chosen["seed"].nunique(), chosen["prior"].nunique()
    lines = [
        f"Lateral specific force on the task (m/s^2, RMS), means over {count[1]} priors and {count[0]} seeds.",
        "",
        "| task | chosen | median | random | best | rank | rank correlation |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.task} | {row.chosen:.3f} | {row.median:.3f} | {row.random:.3f} | {row.best:.3f} "
        f"| {row.rank:.1f} of {row.candidates:.0f} | {row.correlation:.2f} |"
        for row in tasks.itertuples(index=False)
    ]
    lines += ["", "All candidates.", "", *_interval_table(gains)]
    if stricter is not None:
        lines += ["", _STRICTER, "", *_interval_table(stricter)]
    return "\n".join(lines) + "\n"


def _interval_table(gains: pd.DataFrame) -> list[str]:
    return [
        "| chosen minus | m/s^2 | 95 %, tasks | 95 %, Student | 95 %, tasks and priors | relative | tasks better |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| {gain.against} | {gain.difference:.4f} | {gain.low:.4f} to {gain.high:.4f} "
            f"| {gain.low_t:.4f} to {gain.high_t:.4f} | {gain.low_both:.4f} to {gain.high_both:.4f} "
            f"| {gain.relative:.1%} | {gain.tasks_better} of {gain.tasks} |"
            for gain in gains.itertuples(index=False)
        ),
    ]
