"""How fast the pieces of the experiment are, timed side by side: `python -m infotraj.experiment.paper.benchmark`.

Prints a table: a closed-loop MuJoCo flight against real time, and the simulation and scoring of 20 candidates with 10
draws each, piece by piece. Every piece runs once before it is timed (compilation), then `--repeat` times; the median
and the extremes are shown, because machines are noisy.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from infotraj.experiment.common.config import ExperimentConfig, read
from infotraj.experiment.paper import flying, references
from infotraj.experiment.paper.learning import data_of, learn
from infotraj.experiment.paper.selecting import sample_candidates, score, simulate
from infotraj.informative.simulation import EstimateNoise, Simulator
from infotraj.residual.draws import PosteriorDraws
from infotraj.vehicle import load_vehicle


def main() -> None:
    """Times the pieces with the configuration of `--config` on `--threads` cores."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=None, help="configuration; default: the built-in one")
    parser.add_argument("--repeat", type=int, default=5, help="timed runs of each piece")
    parser.add_argument("--threads", type=int, default=2, help="cores for simulation and scoring")
    given = parser.parse_args()
    config = ExperimentConfig() if given.config is None else read(given.config)
    with threadpool_limits(1):
        _report(config, given.repeat, given.threads)


def _report(config: ExperimentConfig, repeat: int, threads: int) -> None:
    vehicle, task = load_vehicle(config.vehicle), references.named(config, "task")
    robot = flying.plant(config, config.plants[0])
    flight = flying.fly(robot, vehicle, task, None, config, np.random.default_rng(0))
    data = data_of(flight, vehicle, config.learning)
    prior = learn(data, config.prior_points, config.learning, np.random.default_rng(1))
    candidates = sample_candidates(
        task, vehicle, config.deviations, config.selection.candidates, np.random.default_rng(2)
    )
    draws = PosteriorDraws.sample(prior, np.random.default_rng(3), config.selection.draws)
    simulator = Simulator(vehicle, prior, config.gains, EstimateNoise(*config.selection.estimate_noise), threads)
    points = max(config.added_points)
    rng = np.random.default_rng(6)
    simulated = simulate(task, candidates, vehicle, prior, config, rng, threads)
    duration = float(task.t[-1])
    count = f"{len(candidates)} candidates x {draws.count} draws x {duration:.0f} s"
    pieces: list[tuple[str, float | None, Callable[[], object]]] = [
        (
            f"closed-loop MuJoCo flight, {duration:.0f} s and {robot.settle:.0f} s of settling, one core",
            duration + robot.settle,
            lambda: flying.fly(robot, vehicle, task, prior, config, np.random.default_rng(5)),
        ),
        ("simulate and score: all of it, region and draws included", None, lambda: _score(config, threads, prior)),
        (f"  simulate {count}", None, lambda: simulator.commands(candidates, draws, np.random.default_rng(4))),
        (
            f"  score {count}",
            None,
            lambda: score(simulated, config.selection.cost, config.selection, points, rng, threads),
        ),
        (
            f"learn {points} points: subset and hyperparameters",
            None,
            lambda: learn(data, points, config.learning, np.random.default_rng(7), prior),
        ),
    ]
    print(f"{'piece':<78} {'median s':>9} {'min':>7} {'max':>7} {'CPU s':>7} {'x real time (CPU)':>18}")
    for name, flown, piece in pieces:
        piece()
        wall, busy = [], []
        for _ in range(repeat):
            start, used = time.perf_counter(), time.process_time()
            piece()
            wall.append(time.perf_counter() - start)
            busy.append(time.process_time() - used)
        own = float(np.median(busy))
        speed = "" if flown is None else f"{flown / np.median(wall):.0f} ({flown / own:.0f})"
        print(f"{name:<78} {np.median(wall):9.3f} {min(wall):7.3f} {max(wall):7.3f} {own:7.3f} {speed:>18}", flush=True)


def _score(config: ExperimentConfig, threads: int, prior) -> None:
    vehicle, task = load_vehicle(config.vehicle), references.named(config, "task")
    rng = np.random.default_rng(8)
    candidates = sample_candidates(task, vehicle, config.deviations, config.selection.candidates, rng)
    simulated = simulate(task, candidates, vehicle, prior, config, rng, threads)
    score(simulated, config.selection.cost, config.selection, max(config.added_points), rng, threads)


if __name__ == "__main__":
    main()
