"""The loop closes: a plant with a hidden effect is flown, diagnosed, and flown again with what was named.

The flights to learn from are flown with the vehicle file alone. `diagnose` names what is missing on them; then one
reference that none of them flew is flown with every controller: the vehicle file alone (nominal), the effects that were
named (right), wrong names fitted to the same flights, a Gaussian process on the vehicle file (gp), one on the named
effects (both), and the hidden effect as it is (oracle). Only the plant and the oracle's flight know the truth.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.diagnosis.adding import add
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.report import summary
from infotraj.diagnosis.report.saving import save_added, save_diagnosed
from infotraj.diagnosis.report.steps import steps
from infotraj.errors import InfotrajError
from infotraj.evaluation.pose_error import pose_error
from infotraj.experiment.closed_loop.residual import Residual, controller, learn, residual_data
from infotraj.experiment.common.config import ClosedLoop, ExperimentConfig
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.common.tables import write_table
from infotraj.flight import Flight, read_flight
from infotraj.models import Model, load_model
from infotraj.models.content import ModelFile
from infotraj.robots.robot import Robot
from infotraj.trajectories.reference import Reference
from infotraj.trajectories.wandering import wandering
from infotraj.vehicle import load_vehicle
from infotraj.writing import write_text


def fly_nominal(
    config: ExperimentConfig, case: str, seed: int, *, truth: Path, flights: Sequence[Path], test: Path
) -> None:
    """Flies the plant with the vehicle file's model: the flights to learn from, and one of the test's reference."""
    model, robot = Model(load_vehicle(config.vehicle)), _plant(config, truth)
    for k, path in enumerate(flights):
        reference = _reference(config, case, seed, f"fit {k}", config.closed_loop.fit_duration)
        _flown(config, robot, model, reference, None, case, seed, f"fit {k}").write(path)
    reference = _test_reference(config, case, seed)
    _flown(config, robot, model, reference, None, case, seed, "nominal").write(test)


def name_effects(
    config: ExperimentConfig, case: str, *, flights: Sequence[Path], right: Path, wrong: Path, numbers: Path, fall: Path
) -> None:
    """Writes the model that the diagnosis makes, a folder of wrong ones, its JSON, and how the held-out error falls."""
    source = Path(config.vehicle)
    model, content = Model(load_vehicle(source)), ModelFile(vehicle=str(source.resolve()))
    flown = [read_flight(path) for path in flights]
    found = diagnose(model, flown, seed=config.base_seed)
    save_diagnosed(found, right, parent=source, content=content, flights=flown)
    wrong.mkdir(parents=True, exist_ok=True)
    for names in config.closed_loop.wrong.get(case, ()):
        made = add(model, names.split("+"), flown)
        save_added(made, wrong / f"{_plain(names)}.yaml", parent=source, flights=flown)
    _write_json(summary.as_dict(found), numbers)
    down = steps(found, seed=config.base_seed)
    rows = [
        {
            "step": label, "axis": axis, "rmse": down.rmse[k, i], "low": down.low[k, i], "high": down.high[k, i],
            "floor": down.floor[i], "unit": down.unit["force" if axis[0] == "f" else "torque"],
        }
        for k, label in enumerate(down.labels)
        for i, axis in enumerate(down.axes)
    ]  # fmt: skip
    write_table(pd.DataFrame(rows), fall)


def fly_again(
    config: ExperimentConfig,
    case: str,
    seed: int,
    *,
    truth: Path,
    oracle: Path,
    flights: Sequence[Path],
    test: Path,
    right: Path,
    wrong: Path,
    table: Path,
) -> None:
    """Flies the test's reference with every controller and writes a row each: `_row` says what it holds."""
    vehicle, robot = load_vehicle(config.vehicle), _plant(config, truth)
    nominal, named = Model(vehicle), load_model(right)
    known = {"right": named, "oracle": load_model(oracle)}
    known |= {f"wrong: {names}": load_model(wrong / f"{_plain(names)}.yaml") for names in _wrong(config, case)}
    reference, held_out = _test_reference(config, case, seed), read_flight(test)
    rows = [_row(case, seed, "nominal", 0, held_out, nominal, None, held_out, config)]
    for name, model in known.items():
        flight = _tried(config, robot, model, reference, None, case, seed, name)
        rows.append(_row(case, seed, name, 0, flight, model, None, held_out, config))
    flown = [read_flight(path) for path in flights]
    for name, model in {"gp": nominal, "both": named}.items():
        data = residual_data(model, flown, config.learning)
        for points in config.closed_loop.points:
            rng = generator(config.base_seed, "closed loop", case, seed, f"learn {name}", points)
            residual = learn(data, points, config.learning, rng)
            flight = _tried(config, robot, model, reference, residual, case, seed, f"{name} {points}")
            rows.append(_row(case, seed, name, points, flight, model, residual, held_out, config))
    write_table(pd.DataFrame(rows), table)


def points_needed(
    config: ExperimentConfig, case: str, seed: int, *, flights: Sequence[Path], test: Path, right: Path, table: Path
) -> None:
    """What a Gaussian process leaves of the held-out flight, with and without the named effects, by its points (0: the
    model alone): a row each, force in m/s^2 and torque in rad/s^2."""
    named, held_out = load_model(right), read_flight(test)
    flown = [read_flight(path) for path in flights]
    rows = []
    for name, model in {"gp": Model(named.vehicle), "both": named}.items():
        data = residual_data(model, flown, config.learning)
        for points in (0, *config.closed_loop.curve):
            rng = generator(config.base_seed, "closed loop", case, seed, f"learn {name}", points)
            residual = learn(data, points, config.learning, rng) if points else None
            row = {"case": case, "seed": seed, "controller": name, "points": points}
            rows.append(row | _left(model, residual, held_out, config))
    write_table(pd.DataFrame(rows), table)


def _row(case, seed, name, points, flight, model, residual, held_out, config) -> dict[str, object]:
    """Tracking error of the flight (NaN where it was lost): position and rotors in m, attitude in rad; and what the
    model leaves of the held-out flight that the nominal controller flew: force in m/s^2, torque in rad/s^2."""
    vehicle = model.vehicle
    found = None if flight is None else pose_error(flight, vehicle)
    return {
        "case": case, "seed": seed, "controller": name, "points": points,
        "effects": "+".join(e.name for e in model.effects),
        "position": np.nan if found is None else found.position,
        "attitude": np.nan if found is None else found.attitude,
        "rotors": np.nan if found is None else found.rotors,
    } | _left(model, residual, held_out, config)  # fmt: skip


def _left(model: Model, residual: Residual | None, held_out: Flight, config: ExperimentConfig) -> dict[str, float]:
    data = residual_data(model, [held_out], config.learning)
    left = data.outputs - (0.0 if residual is None else residual.mean(data.inputs))
    force, torque = (float(np.sqrt(np.mean(part**2))) for part in (left[:, :3], left[:, 3:]))
    return {"force_left": force, "torque_left": torque}


def _plant(config: ExperimentConfig, truth: Path) -> Robot:
    from infotraj.robots.plant.plant import Plant  # late: mujoco

    return Plant.load(load_vehicle(config.vehicle), truth)


def _reference(config: ExperimentConfig, case: str, seed: int, purpose: str, duration: float) -> Reference:
    chosen: ClosedLoop = config.closed_loop
    rng = generator(config.base_seed, "closed loop", case, seed, f"reference {purpose}")
    return wandering(duration, chosen.place, np.radians(chosen.angle_deg), rng, config.sample_time, chosen.tempo)


def _test_reference(config: ExperimentConfig, case: str, seed: int) -> Reference:
    return _reference(config, case, seed, "test", config.closed_loop.test_duration)


def _flown(
    config: ExperimentConfig,
    robot: Robot,
    model: Model,
    reference: Reference,
    residual: Residual | None,
    case: str,
    seed: int,
    purpose: str,
) -> Flight:
    # Controllers of one seed meet the same noise on the test's reference: what differs is the controller.
    noise = purpose if purpose.startswith("fit") else "test"
    rng = generator(config.base_seed, "closed loop", case, seed, f"noise {noise}")
    return robot.fly(reference, controller(model, reference, config.gains, residual), rng)


def _tried(*arguments) -> Flight | None:
    """The flight; None, with a line in the log, where it was lost."""
    try:
        return _flown(*arguments)
    except InfotrajError as error:
        print(f"{arguments[-1]}: {error}", flush=True)
        return None


def _wrong(config: ExperimentConfig, case: str) -> Iterator[str]:
    yield from config.closed_loop.wrong.get(case, ())


def _plain(names: str) -> str:
    return names.replace(":", "_")


def _write_json(content: object, path: Path) -> None:
    write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", path)
