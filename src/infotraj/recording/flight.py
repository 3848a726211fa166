"""A flight, or a simulated rollout of one, as a recording that the rerun viewer opens as it is."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pandas as pd
import rerun as rr
import rerun.blueprint as rrb

from infotraj.flight import Flight
from infotraj.recording import signals
from infotraj.recording.layout import AXES, blueprint
from infotraj.recording.scene import FLOWN, REFERENCE, add_scene, center_of, reach
from infotraj.recording.signals import Achieved, Band, Residual, Samples, thinned
from infotraj.recording.stream import Columns, recording
from infotraj.residual.learning_data import LearningData
from infotraj.vehicle import Vehicle

RATE = 100.0  # samples a second of a plotted line
COMMANDED, ACHIEVED = REFERENCE, FLOWN
LEARNED, EDGE = (0, 114, 178), (120, 175, 215)
AXIS_COLORS = ((213, 94, 0), (0, 158, 115), (86, 180, 233))
NORM = (200, 200, 200)


def record_flight(
    path: str | Path,
    flight: Flight,
    vehicle: Vehicle,
    *,
    gp: Residual | None = None,
    data: LearningData | None = None,
    rollout: bool = False,
) -> None:
    """Writes a flight as a rerun recording with its layout; what the flight does not hold is left out.

    The achieved torque comes from the rate's derivative. gp: the learned residual, drawn with its band of two standard
    deviations along the commanded wrench or, so that it compares with what it was learned from, along the inputs of
    `data` (residual.learning_data of this flight). rollout: the flight was simulated with the learned model, and is
    named so. InputError where a residual has no scale.
    """
    groups = _groups(flight, vehicle, signals.achieved_torque(flight, vehicle), data)
    band = None if gp is None else signals.predicted_residual(flight, vehicle, gp, data, RATE)

    def layout(columns: Columns) -> rrb.Blueprint:
        return blueprint(*center_of(flight), reach(vehicle), columns.spans)

    application = "infotraj rollout" if rollout else "infotraj flight"
    with recording(path, application, _identity(flight, vehicle, rollout), layout) as columns:
        columns.static("about", _about(flight, vehicle, gp is not None, rollout))
        add_scene(columns, flight, vehicle)
        _add_wrench(columns, flight, groups)
        for group in ("error/position", "error/attitude", "error/angular_acceleration"):
            _add_error(columns, group, groups[group])
        _add_residual(columns, groups["residual"], band)


def _groups(
    flight: Flight, vehicle: Vehicle, achieved: Achieved | None, data: LearningData | None
) -> dict[str, Samples | None]:
    return {
        "force": signals.achieved_force(flight, vehicle),
        "torque": None if achieved is None else achieved.torque,
        "error/position": signals.position_error(flight),
        "error/attitude": signals.attitude_error(flight),
        "error/angular_acceleration": signals.angular_acceleration_error(flight, vehicle, achieved),
        "residual": signals.seen_residual(flight, vehicle, achieved, data),
    }


def _add_wrench(columns: Columns, flight: Flight, groups: dict[str, Samples | None]) -> None:
    for group, first in (("force", 0), ("torque", 3)):
        lines = {"achieved": (groups[group], ACHIEVED), "commanded": (signals.commanded(flight, first), COMMANDED)}
        for name, (samples, color) in lines.items():
            if samples is not None:
                for k, axis in enumerate(AXES):
                    _add_line(columns, f"{group}/{axis}/{name}", samples, k, name, color)


def _add_error(columns: Columns, group: str, error: Samples | None) -> None:
    if error is not None:
        norm = Samples(error.t, np.linalg.norm(error.values, axis=1, keepdims=True))
        _add_line(columns, f"{group}/norm", norm, 0, "norm", NORM)
        for k, axis in enumerate(AXES):
            _add_line(columns, f"{group}/{axis}", error, k, axis, AXIS_COLORS[k])


def _add_residual(columns: Columns, seen: Samples | None, band: Band | None) -> None:
    for k, axis in enumerate(AXES):
        if seen is not None:
            _add_line(columns, f"residual/{axis}/seen", seen, k, "seen", ACHIEVED)
        if band is not None:
            edges = [("lower", -1, "- 2 sigma"), ("upper", 1, "+ 2 sigma")]
            for name, side, label in edges:
                values = band.mean + side * band.two_sigma
                columns.series(f"residual/{axis}/{name}", band.t, values[:, k], label, EDGE, width=1.0)
            columns.series(f"residual/{axis}/mean", band.t, band.mean[:, k], "learned mean", LEARNED, width=2.5)


def _add_line(columns: Columns, entity: str, samples: Samples, k: int, name: str, color: tuple) -> None:
    keep = thinned(samples.t, RATE)
    columns.series(entity, samples.t[keep], samples.values[keep, k], name, color)


def _identity(flight: Flight, vehicle: Vehicle, rollout: bool) -> str:
    content = pd.util.hash_pandas_object(flight.table, index=False).to_numpy().tobytes()
    return hashlib.sha256(content + f"{vehicle.model_dump_json()}{rollout}".encode()).hexdigest()[:24]


def _about(flight: Flight, vehicle: Vehicle, learned: bool, rollout: bool) -> rr.TextDocument:
    kind = "Simulated rollout with the learned model" if rollout else "Flight"
    known = {k: v for k, v in flight.meta.items() if isinstance(v, str | int | float) and k != "source"}
    lines = [
        f"**{kind} of {vehicle.name}**, {flight.t[-1] - flight.t[0]:.1f} s, {len(vehicle.rotors)} rotors, "
        f"{len(vehicle.tilts)} tilting arms.",
        "",
        "Orange arrows: thrust of each rotor, as commanded, along its axis; a lower rotor's arrow "
        "ends at its disc. Discs: blue turns counter-clockwise, pink clockwise. Red arrow: forward.",
        "",
        "Green: flown path, yellow: reference. The thin arrows and the curves at their tips show the body's z axis.",
    ]
    if learned:
        lines += ["", "Tab Residual: what the learned model expects at the commanded wrench, with its two-sigma band."]
    lines += ["", ", ".join(f"{k}: {v}" for k, v in known.items())]
    return rr.TextDocument("\n".join(lines), media_type=rr.MediaType.MARKDOWN)
