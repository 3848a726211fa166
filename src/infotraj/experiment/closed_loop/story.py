"""The story in one figure: a model fails, where, what is missing, how the error falls, and the better flight."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.comparing.equation_error import AXES, equation_error
from infotraj.experiment.closed_loop.summary import RESAMPLES
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.experiment.common.tables import gather
from infotraj.flight import Flight, read_flight
from infotraj.locating.locating import locate
from infotraj.locating.places import Place as Located
from infotraj.locating.quantities import quantities
from infotraj.models import Model, load_model
from infotraj.rotations import Array

_SECONDS = 8.0  # of the flight are drawn
_RANKED = 7  # effects are drawn


def story(
    config: ExperimentConfig,
    *,
    flight: Path,
    flights: Sequence[Path],
    model: Path,
    numbers: Path,
    fall: Path,
    runs: Path,
    png: Path,
    pdf: Path,
) -> None:
    """Draws the figure for the case that the configuration shows.

    flight: one that no fit saw, with the model as given and with the named effects; flights: those that the diagnosis
    was given, and where the model fails on them; the diagnosis and the fall of its held-out error; all seeds of the
    case flown again.
    """
    from infotraj.plots.story import Fall, Flown, Place, Ranking, Story, Wrench, draw  # late: matplotlib

    named, recorded = load_model(model), read_flight(flight)
    given = Model(named.vehicle)
    before, after = equation_error(given, recorded), equation_error(named, recorded)
    learned = [read_flight(path) for path in flights]
    # The place that explains most of its axis, in the flights that the diagnosis was given.
    place = max(locate(given, learned).places, key=lambda p: p.explained)
    steps = pd.read_csv(fall)
    labels = list(dict.fromkeys(steps["step"]))
    torque = _most_changed(steps, labels, "t")
    axis = AXES.index(torque)
    held = np.flatnonzero(before.scored[:, axis] & after.scored[:, axis])
    begin = max(before.t[held[0]], min(recorded.t[0] + 4.0, before.t[held[-1]] - _SECONDS))
    shown = held[(before.t[held] >= begin) & (before.t[held] <= begin + _SECONDS)]
    unit = before.unit["torque"]
    wrench = Wrench(
        before.t[shown], before.measured[shown, axis], before.predicted[shown, axis], after.predicted[shown, axis],
        torque, unit,
    )  # fmt: skip
    where = Place(
        *_at_place(place, given, named, learned), place.axis, place.unit, place.quantity.name, place.quantity.unit
    )
    effects = [e for e in json.loads(Path(numbers).read_text())["effects"] if e["rise"] is not None]
    effects.sort(key=lambda e: -e["rise"])
    first = effects[:_RANKED]
    ranking = Ranking([e["name"] for e in first], np.array([e["rise"] for e in first]), [e["verdict"] for e in first])
    force = _most_changed(steps, labels[-2:] if len(labels) > 1 else labels, "f")
    down = Fall(labels, {a: _over_floor(steps, labels, a) for a in (torque, force)})
    draw(Story(wrench, where, ranking, down, _flown(config, pd.read_csv(runs), Flown)), Path(png), Path(pdf))


def draw_points(*, tables: Sequence[Path], table: Path, png: Path, pdf: Path) -> None:
    """Writes the rows of all tables below each other and draws what is left against the number of points."""
    from infotraj.plots.points_needed import points_needed  # late: matplotlib

    gather(tables=tables, table=table)
    points_needed(pd.read_csv(table), Path(png), Path(pdf))


def _at_place(place: Located, given: Model, named: Model, flights: Sequence[Flight]) -> tuple[Array, Array, Array]:
    """The place's quantity and the residuals of both models there, at the rows of all flights that hold all three."""
    axis, parts = AXES.index(place.axis), []
    for flight in flights:
        errors = [equation_error(m, flight) for m in (given, named)]
        known = {q.name: q for q in quantities(flight, given.vehicle, errors[0].window)}
        part = np.stack([known[place.quantity.name].values, *(e.residual[:, axis] for e in errors)])
        parts.append(part[:, np.isfinite(part).all(axis=0)])
    return tuple(np.concatenate(parts, axis=1))


def _most_changed(steps: pd.DataFrame, labels: list[str], kind: str) -> str:
    """The axis of that kind whose error falls most, relative to its floor, over these steps."""
    part = steps[steps["axis"].str.startswith(kind)]
    table = part.assign(ratio=part["rmse"] / part["floor"]).pivot_table(index="axis", columns="step", values="ratio")
    return str((table[labels[0]] - table[labels[-1]]).idxmax())


def _over_floor(steps: pd.DataFrame, labels: list[str], axis: str) -> tuple[Array, Array, Array]:
    part = steps[steps["axis"] == axis].set_index("step").loc[labels]
    return tuple((part[c] / part["floor"]).to_numpy() for c in ("rmse", "low", "high"))


def _flown(config: ExperimentConfig, runs: pd.DataFrame, kind: type) -> list:
    """Tracking error (mm) of each seed and controller of the case shown, the largest Gaussian processes."""
    part = runs[runs["case"] == config.closed_loop.shown]
    most = part["points"].max()
    part = part[(part["points"] == 0) | (part["points"] == most)]
    words = {
        "nominal": "As given", "gp": f"Gaussian process\nalone ({most} points)", "right": "Named effects",
        "both": "Named effects and\nGaussian process", "oracle": "True effects",
    }  # fmt: skip
    order = ["nominal", *sorted(c for c in part["controller"].unique() if c.startswith("wrong")), "gp", "right", "both"]
    flown = []
    rng = np.random.default_rng(0)
    for name in [*order, "oracle"]:
        values = 1e3 * part.loc[part["controller"] == name, "rotors"].dropna().to_numpy()
        if not len(values):
            continue
        drawn = values[rng.integers(len(values), size=(RESAMPLES, len(values)))].mean(axis=1)
        label = words.get(name) or "Wrong: " + name.removeprefix("wrong: ").replace("_", " ").replace("+", "\nand ")
        flown.append(kind(label, values, float(values.mean()), *map(float, np.percentile(drawn, [2.5, 97.5])), name))
    return flown
