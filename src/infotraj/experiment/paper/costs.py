"""Which cost would have chosen well: many costs of the same simulated candidates, held against hindsight.

One thing at a time is changed of the cost that the run uses (eq. 13 with one fixed lengthscale): its lengthscales,
whether they differ from input to input, the subset that counts, the region, the points. Then come costs of another
kind. All see the candidates in simulation alone, as the run's own does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import KDTree

from infotraj.experiment.common.config import Cost, ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper.choosing import candidates_of
from infotraj.experiment.paper.effect_columns import effect_columns
from infotraj.experiment.paper.learning import options
from infotraj.experiment.paper.rollouts import as_flight
from infotraj.experiment.paper.selecting import TASK, Simulated, score, simulate
from infotraj.informative.cost import Scorer, of_one_lengthscale
from infotraj.informative.linear_prior import LinearPrior, Rows, in_the_wrench
from infotraj.informative.region import visited_region
from infotraj.informative.simulation import EstimateNoise, Simulator
from infotraj.residual import hyperparameters
from infotraj.residual.draws import PosteriorDraws
from infotraj.residual.gaussian_process import GaussianProcess
from infotraj.residual.subset import farthest_first, k_medoids
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference, read_reference
from infotraj.vehicle import load_vehicle

OURS, LITERAL = "eq. 13, one lengthscale 1.0 (the run's)", "the paper's, word for word"
_POINTS, _THINNED, _REGION, _FEW_DRAWS = 40, 5, 300, 2

Named = Iterator[tuple[str, Array]]


def hold_costs(config: ExperimentConfig, plant: str, seed: int, *, task: Path, model: Path, table: Path) -> None:
    """Writes a row a cost and candidate of the run's first round: the cost, smaller being better by its own lights.

    Costs that can be configured are also taken of the task's own flight, candidate -1: would they fly it again?
    """
    around, prior = read_reference(task), GaussianProcess.load(model)
    vehicle = load_vehicle(config.vehicle)
    candidates = candidates_of(config, plant, seed, 1, around)
    rng = generator(config.base_seed, plant, seed, "score", 1)
    simulated = simulate(around, candidates, vehicle, prior, config, rng)

    def fresh(what: str) -> np.random.Generator:
        return generator(config.base_seed, plant, seed, "costs", what)

    rows = []
    groups = {
        "configured": _configured(simulated, config, fresh),
        "kernel": _kernels(simulated, config, fresh),
        "no process": _without_a_process(simulated),
        "affine": _affine(simulated, fresh),
        "effects": _effects(simulated, config, fresh),
        "propagated": _propagated(simulated, config, fresh),
    }
    for group in config.hindsight.costs:
        for name, values in groups[group]:
            rows += [
                {"plant": plant, "seed": seed, "group": group, "cost": name, "candidate": k, "value": value}
                for k, value in zip([*range(len(candidates)), TASK], values, strict=False)
            ]
            print(f"{group}: {name}", flush=True)
    write_table(pd.DataFrame(rows), table)


def _configured(simulated: Simulated, config: ExperimentConfig, fresh: Callable) -> Named:
    """Costs that `selection.cost` can be set to."""
    settings, most = config.selection, max(config.added_points)
    variants = {OURS: Cost(), LITERAL: settings.paper}
    variants |= {f"one lengthscale {length:g}": Cost(lengthscale=length) for length in (0.3, 0.5, 2.0, 3.0, 5.0, 10.0)}
    variants |= {f"one lengthscale 1, noise {noise:g}": Cost(noise=noise) for noise in (0.03, 0.3)}
    variants |= {
        f"one lengthscale 1, k-medoids, {_POINTS} points": Cost(subset="medoids"),
        "one lengthscale 1, k-medoids, as many points as learned": Cost(subset="medoids", points=None),
        "one lengthscale 1, farthest first, as many points as learned": Cost(points=None),
        "one lengthscale 1, uniform region": Cost(region="uniform"),
        "fitted kernel, k-medoids, as many points as learned": Cost(kernel="fitted", subset="medoids", points=None),
        f"fitted kernel, farthest first, {_POINTS} points": Cost(kernel="fitted"),
    }
    for name, cost in variants.items():
        yield name, score(simulated, cost, settings, most, fresh("region")).costs.mean(axis=1)
    few = replace(simulated, commands=simulated.commands[:, :1], task=simulated.task[:1])
    yield "one lengthscale 1, one draw", score(few, Cost(), settings, most, fresh("region")).costs.mean(axis=1)


def _kernels(simulated: Simulated, config: ExperimentConfig, fresh: Callable) -> Named:
    """What of the fitted kernel spoils the cost: its length, its shape over the inputs, or its variances."""
    prior = simulated.prior
    fitted, middle = prior.lengthscales, _geometric_mean(prior.lengthscales)
    unit, quiet = np.ones(3), np.full(3, 0.01)
    alike = hyperparameters.fit(
        prior.X, prior.Y, fresh("one lengthscale"), **{**options(config.learning), "ard": False}
    )
    kinds = {
        "fitted lengthscales, variances fixed": (fitted, unit, quiet),
        "fitted lengthscales / 3, variances fixed": (fitted / 3.0, unit, quiet),
        "fitted lengthscales / 10, variances fixed": (fitted / 10.0, unit, quiet),
        "fitted shape, geometric mean 1, variances fixed": (fitted / middle, unit, quiet),
        "geometric mean of the fitted ones for all inputs, variances fixed": (middle + 0 * fitted, unit, quiet),
        "one lengthscale fitted (in expected spreads), variances fitted": (
            alike.lengthscales,
            alike.signal_variance,
            alike.noise_variance,
        ),
        "one lengthscale 1, variances fitted": (np.ones_like(fitted), prior.signal_variance, prior.noise_variance),
    }
    for name, (lengths, signal, noise) in kinds.items():
        process = GaussianProcess(prior.X, prior.Y, lengths, signal, noise, prior.prior_mean)
        yield name, _scored(simulated, process, config, fresh)
    sampled = hyperparameters.sample_hyperparameters(prior, fresh("averaged"), 8, **options(config.learning))
    yield (
        "fitted kernel, mean over 8 draws of it",
        np.mean([_scored(simulated, process, config, fresh) for process in sampled], axis=0),
    )


def _scored(simulated: Simulated, process: GaussianProcess, config: ExperimentConfig, fresh: Callable) -> Array:
    """The cost by another process, all else as the run's."""
    settings = config.selection
    where = visited_region(simulated.visited, settings.region_points, fresh("region"))
    scorer = Scorer(process, where, _POINTS, _farthest)
    return scorer.costs(simulated.commands[:-1], fresh("score")).mean(axis=1)


def _without_a_process(simulated: Simulated) -> Named:
    flights = simulated.commands[:-1]
    where = simulated.visited[:: 2 * _THINNED]
    yield (
        "mean distance from the region to the nearest point of the candidate",
        np.array([np.mean([KDTree(one).query(where)[0].mean() for one in draws]) for draws in flights]),
    )
    torque = flights[..., 3:]
    shaken = np.sqrt(np.mean(torque**2, axis=(1, 2, 3)))
    yield "the most torque (root mean square)", -shaken
    yield "the least torque", shaken
    apart = flights.mean(axis=1) - simulated.commands[-1].mean(axis=0)
    yield "the smallest change of the commands against the task's", np.sqrt(np.mean(apart**2, axis=(1, 2)))
    yield (
        "the least change of torque (root mean square)",
        np.sqrt(np.mean(np.diff(torque.mean(axis=1), axis=1) ** 2, axis=(1, 2))),
    )


def _affine(simulated: Simulated, fresh: Callable) -> Named:
    """Affine in the wrench plus a small squared exponential, and the variance of its slopes alone."""
    middle = np.array([0.0, 0.0, 9.81, 0.0, 0.0, 0.0])

    def rows(inputs: Array) -> Rows:
        return in_the_wrench(inputs - middle, 3.0, 0.3)

    where = rows(visited_region(simulated.visited, _REGION, fresh("region")))
    before = rows(simulated.prior.X)
    # columns of the weights: three outputs of one steady and six slopes; 4 to 6 are those against the torque
    slopes = np.concatenate([7 * o + np.arange(4, 7) for o in range(3)])
    for rest in (0.1, 0.3, 1.0):
        prior = LinearPrior(rest=rest)
        left, turned = [], []
        for draws in simulated.commands[:-1, : 2 * _FEW_DRAWS]:
            data = [before + rows(_chosen(one)) for one in draws]
            left.append(np.mean([prior.variance(d, where).sum(axis=1).mean() for d in data]))
            turned.append(np.mean([np.diag(prior.weights(d))[slopes].sum() for d in data]))
        yield f"affine plus a process of {rest:g} rad/s^2", np.array(left)
        if rest == 0.3:
            yield "variance of its slopes against the torque alone", np.array(turned)


def _effects(simulated: Simulated, config: ExperimentConfig, fresh: Callable) -> Named:
    """The catalogue's columns of usual size plus a small process: posterior variance where the task goes."""
    vehicle = load_vehicle(config.vehicle)
    noise = EstimateNoise(*config.selection.estimate_noise)
    simulator = Simulator(vehicle, simulated.prior, config.gains, noise)
    draws = simulated.draws

    def rows(reference: Reference) -> list[Rows]:
        commands, moved = simulator.rollout(reference, draws.part(0, 1), fresh("rollout"))
        found = []
        for one, state in zip(commands, moved, strict=True):
            _, columns = effect_columns(vehicle, as_flight(vehicle, reference, one, state))
            found.append(Rows(columns[::_THINNED], one[::_THINNED]))
        return found

    task = rows(simulated.references[-1])
    where = [one[np.linspace(0, len(one.inputs) - 1, _REGION).astype(int)] for one in task]
    before = [one[k_medoids(one.inputs, simulated.prior.n, fresh("before"))] for one in task]
    flights = [rows(reference) for reference in simulated.references[:-1]]
    for rest in (0.1, 0.3, 1.0):
        prior = LinearPrior(rest=rest)
        left = [
            np.mean(
                [
                    prior.variance(b + one[farthest_first(one.inputs, _POINTS)], z).sum(axis=1).mean()
                    for b, one, z in zip(before, flight, where, strict=True)
                ]
            )
            for flight in flights
        ]
        yield f"effects of usual size plus a process of {rest:g} rad/s^2", np.array(left)


def _propagated(simulated: Simulated, config: ExperimentConfig, fresh: Callable) -> Named:
    """The closed-loop error that a draw would meet once its simulated flight is learned, hyperparameters kept."""
    vehicle, prior = load_vehicle(config.vehicle), simulated.prior
    noise = EstimateNoise(*config.selection.estimate_noise)
    for name, process in (("fitted kernel", prior), ("one lengthscale 1", _three(prior))):
        draws = PosteriorDraws.sample(process, fresh("draws"), 2 * _FEW_DRAWS)
        robots = [draws.part(k, k + 1) for k in range(draws.count)]
        errors = []
        for flights in simulated.commands[:-1]:
            each = []
            for robot, flight in zip(robots, flights, strict=False):
                added = _chosen(flight)
                seen = robot(added)[0]
                seen = seen + np.sqrt(process.noise_variance) * fresh("noise").standard_normal(seen.shape)
                learned = process.condition(added, seen)
                simulator = Simulator(vehicle, learned, config.gains, noise)
                flown = simulator.commands([simulated.references[-1]], robot, fresh("loop"))[0, 0][::_THINNED]
                each.append(np.abs(robot(flown)[0] - learned.mean(flown)).mean())
            errors.append(np.mean(each))
        yield f"closed-loop error of draws, {name}", np.array(errors)


def _three(prior: GaussianProcess) -> GaussianProcess:
    """The prior's data under one lengthscale and fixed variances, all three outputs."""
    one = of_one_lengthscale(prior, 1.0, 0.1)
    lengths = np.repeat(one.lengthscales, 3, axis=0)
    return GaussianProcess(prior.X, prior.Y, lengths, np.ones(3), np.full(3, 0.01), prior.prior_mean)


def _farthest(X: Array, count: int, rng: np.random.Generator):
    return farthest_first(X, count)


def _chosen(flight: Array) -> Array:
    thinned = flight[::_THINNED]
    return thinned[farthest_first(thinned, _POINTS)]


def _geometric_mean(lengthscales: Array) -> Array:
    """Of each output over its inputs, (m, 1)."""
    return np.exp(np.log(lengthscales).mean(axis=1, keepdims=True))
