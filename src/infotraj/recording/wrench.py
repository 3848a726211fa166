"""Measured and predicted wrench of a model along a flight, for the rerun viewer: where and when does it fail?"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import rerun as rr
import rerun.blueprint as rrb

from infotraj.checking.acceptance import accepted_in, accepted_lines
from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.statistics import statistics
from infotraj.effects import labels_in_words
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.recording.scene import VEHICLE, add_scene, center_of, reach
from infotraj.recording.signals import at, estimated, thinned
from infotraj.recording.stream import TIMELINE, Columns, recording
from infotraj.rotations import Array

RATE, PATH_RATE = 50.0, 20.0  # samples a second of arrows and lines; of the coloured path
# As in the report and in the figures of `compare`; told apart by the colour-blind.
MEASURED, BAND = (154, 161, 168), (120, 175, 215)
MODELS = ((0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0))
WORST = 10.0  # times the floor at which the path's colour is darkest
# From within the noise to WORST times the floor: blue, yellow, red.
_RAMP = np.array([[86.0, 180.0, 233.0], [240.0, 228.0, 66.0], [213.0, 30.0, 30.0]])
_KIND = {"f": "force", "t": "torque"}
# Force in full, torque in lighter colours: measured, predicted, their difference.
_COLORS = {
    "force": (MEASURED, MODELS[0], (230, 159, 0)),
    "torque": ((190, 195, 200), (140, 190, 230), (240, 190, 90)),
}


def record_comparison(
    path: str | Path,
    flight: Flight,
    model: Model,
    errors: EquationError | Mapping[str, EquationError],
    corrections: Collection[str] = (),
) -> None:
    """Writes a recording of one flight with its measured and predicted wrench.

    Arrows on the vehicle, body frame: measured and predicted force, and their difference many times larger (the text
    says how many); the same for the torque. The path is coloured by the error over the floor, and one group of plots an
    axis shows measured, predicted, and the residual with its noise band, on the viewer's one timeline. errors: of
    `model`, or of several by name, `model` first; the further ones are in the plots and in the text alone.
    corrections: labels of its effects that correct the vehicle file.
    """
    error = errors if isinstance(errors, EquationError) else next(iter(errors.values()))
    models = errors if isinstance(errors, Mapping) and len(errors) > 1 else {"predicted": error}
    size = reach(model.vehicle)
    scales = _scales(error, size)

    def layout(columns: Columns) -> rrb.Blueprint:
        # The rotors' own thrust arrows would hide those of the wrench.
        hidden = [e for e in columns.entities if e.endswith("/thrust")]
        return _blueprint(*center_of(flight), size, columns.spans, hidden, error.unit)

    content = pd.util.hash_pandas_object(flight.table, index=False).to_numpy().tobytes()
    about = f"{model.effects!r}{model.vehicle.model_dump_json()}{list(models)}"
    predicted = b"".join(np.ascontiguousarray(e.predicted).tobytes() for e in models.values())
    identity = hashlib.sha256(content + about.encode() + predicted)
    with recording(path, "infotraj comparison", identity.hexdigest()[:24], layout) as columns:
        add_scene(columns, flight, model.vehicle)
        columns.static("about", _about(flight, model, models, scales, corrections))
        _add_path(columns, flight, error, size)
        _add_arrows(columns, error, scales, size)
        _add_lines(columns, models)


def _scales(error: EquationError, size: float) -> dict[str, tuple[float, float]]:
    """Metres a unit for the wrench, and how many times more for the residual, of force and torque."""
    scales = {}
    for kind, part in (("force", slice(0, 3)), ("torque", slice(3, 6))):
        length = np.linalg.norm(error.measured[:, part], axis=1)
        off = np.linalg.norm(error.residual[:, part], axis=1)
        if not np.isfinite(off).any():
            continue
        unit = 1.6 * size / max(float(np.nanpercentile(length, 95)), 1e-12)
        more = 0.8 * float(np.nanpercentile(length, 95)) / max(float(np.nanpercentile(off, 95)), 1e-12)
        scales[kind] = (unit, float(2.0 ** np.clip(np.floor(np.log2(max(more, 1.0))), 0, 10)))
    return scales


def _add_path(columns: Columns, flight: Flight, error: EquationError, size: float) -> None:
    position = estimated(flight, ("px", "py", "pz"))
    if position is None:
        return
    with np.errstate(invalid="ignore", divide="ignore"):
        square = (error.residual / error.floor) ** 2
    known = np.isfinite(square).any(axis=1)
    if not known.any():
        return
    over = np.sqrt(np.nanmean(square[known], axis=1))
    t = error.t[known]
    keep = thinned(t, PATH_RATE)
    points = at(position, t[keep])
    joined = np.diff(t[keep]) < 0.5
    share = 2.0 * np.clip(np.log(np.maximum(over[keep], 1.0)) / np.log(WORST), 0.0, 1.0)
    colors = np.stack([np.interp(share, [0.0, 1.0, 2.0], ramp) for ramp in _RAMP.T], axis=1).astype(np.uint8)
    strips = [points[i : i + 2] for i in np.flatnonzero(joined)]
    columns.static("world/error_path", rr.LineStrips3D(strips, colors=colors[:-1][joined], radii=0.03 * size))


def _add_arrows(columns: Columns, error: EquationError, scales: dict[str, tuple[float, float]], size: float) -> None:
    for kind, part, radius in (("force", slice(0, 3), 0.035), ("torque", slice(3, 6), 0.025)):
        if kind not in scales:
            continue
        unit, more = scales[kind]
        measured, predicted = error.measured[:, part], error.predicted[:, part]
        rows = np.flatnonzero(np.isfinite(measured).all(axis=1) & np.isfinite(predicted).all(axis=1))
        rows = rows[thinned(error.t[rows], RATE)]
        for name, values, factor, color in (
            ("measured", measured, unit, _COLORS[kind][0]),
            ("predicted", predicted, unit, _COLORS[kind][1]),
            ("residual", measured - predicted, unit * more, _COLORS[kind][2]),
        ):
            entity = f"{VEHICLE}/wrench/{kind}_{name}"
            thick = radius * size * (0.6 if name == "measured" else 1.0)
            columns.static(entity, rr.Arrows3D.from_fields(colors=color, radii=thick))
            columns.arrow(entity, error.t[rows], np.zeros((len(rows), 3)), factor * values[rows])


def _add_lines(columns: Columns, models: Mapping[str, EquationError]) -> None:
    for a, axis in enumerate(AXES):
        for k, (name, error) in enumerate(models.items()):
            rows = np.flatnonzero(error.scored[:, a])
            if not len(rows):
                continue
            rows = rows[thinned(error.t[rows], RATE)]
            t, color, number = error.t[rows], MODELS[k % len(MODELS)], f"_{k + 1}" if k else ""
            if k == 0:
                columns.series(f"wrench/{axis}/measured", t, error.measured[rows, a], "measured", MEASURED, 2.5)
                for side, sign in (("upper", "+"), ("lower", "-")):
                    edge = np.full(2, float(f"{sign}2") * error.floor[a])
                    columns.series(f"residual/{axis}/{side}", t[[0, -1]], edge, f"{sign} 2 floor", BAND, 1.0)
            left = name if len(models) > 1 else "measured - predicted"
            columns.series(f"wrench/{axis}/predicted{number}", t, error.predicted[rows, a], name, color)
            columns.series(f"residual/{axis}/residual{number}", t, error.residual[rows, a], left, color)


def _blueprint(
    center: Array,
    extent: float,
    size: float,
    spans: dict[str, tuple[float, float]],
    hidden: list[str],
    unit: dict[str, str],
) -> rrb.Blueprint:
    distance = max(4.5 * size, 1.3 * extent)
    eye = center + distance * np.array([-0.55, -0.72, 0.42])
    scene = rrb.Spatial3DView(
        origin="world",
        name="Path: blue within the noise, red at 10 times the floor",
        contents=["+ $origin/**", "- /world/flown/**", "- /world/reference/**", *(f"- /{e}" for e in sorted(hidden))],
        eye_controls=rrb.EyeControls3D(position=eye, look_target=center, eye_up=[0, 0, 1]),
        line_grid=rrb.LineGrid3D(visible=True, spacing=max(0.1, round(size, 1))),
    )
    near = rrb.Spatial3DView(
        origin=VEHICLE,
        name="Vehicle: grey measured, blue predicted, orange the difference enlarged",
        contents=["+ $origin/**", *(f"- /{e}" for e in sorted(hidden))],
        eye_controls=rrb.EyeControls3D(
            position=np.array([-1.9, -2.5, 1.5]) * size, look_target=[0, 0, 0.5 * size], eye_up=[0, 0, 1]
        ),
    )
    tabs = [
        rrb.Vertical(*views, name=name)
        for name, axes, kind in (
            ("Force error", AXES[:3], "residual"),
            ("Torque error", AXES[3:], "residual"),
            ("Force", AXES[:3], "wrench"),
            ("Torque", AXES[3:], "wrench"),
        )
        if (views := [v for a in axes if (v := _plot(kind, a, unit[_KIND[a[0]]], spans)) is not None])
    ]
    left = rrb.Vertical(scene, near, rrb.TextDocumentView(origin="about", name="About"), row_shares=[3, 3, 1.4])
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Tabs(*tabs, active_tab=0), column_shares=[1.0, 1.1]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def _plot(kind: str, axis: str, unit: str, spans: dict[str, tuple[float, float]]) -> rrb.TimeSeriesView | None:
    inside = [span for entity, span in spans.items() if entity.startswith(f"{kind}/{axis}/")]
    if not inside:
        return None
    low, high = min(s[0] for s in inside), max(s[1] for s in inside)
    margin = 0.08 * (high - low) or 1.0
    what = "measured - predicted, band of the noise" if kind == "residual" else "measured and predicted"
    return rrb.TimeSeriesView(
        origin=f"{kind}/{axis}",
        name=f"{axis} [{unit}]: {what}",
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        axis_y=rrb.ScalarAxis(range=(low - margin, high + margin)),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
    )


def _about(
    flight: Flight,
    model: Model,
    models: Mapping[str, EquationError],
    scales: dict[str, tuple[float, float]],
    corrections: Collection[str],
) -> rr.TextDocument:
    effects = labels_in_words([e.label for e in model.effects if e.label not in corrections]) or "no effects"
    corrects = labels_in_words([e.label for e in model.effects if e.label in corrections])
    lines = [f"**{model.vehicle.name} with {effects}**, {Path(str(flight.meta.get('source', 'flight'))).name}", ""]
    lines += [f"The vehicle file is corrected by {corrects}.", ""] if corrects else []
    first, error = next(iter(models.items()))
    for kind, (_, more) in scales.items():
        look = "pale" if kind == "torque" else "strong"
        lines.append(
            f"{kind} ({look} arrows): grey measured, blue {first}, orange the difference, {more:.0f} times larger."
        )
    for name, one in models.items():
        lines.append(f"\nRMSE{f', {name}' if len(models) > 1 else ''}: {_rmse(one, error.floor)}")
    lines += ["", error.filter]
    lines += [f"\n{line}" for line in accepted_lines(accepted_in([flight]))]
    lines += [f"\n{axis}: {why}" for axis, why in error.reasons.items()]
    return rr.TextDocument("\n".join(lines), media_type=rr.MediaType.MARKDOWN)


def _rmse(error: EquationError, floor: Array) -> str:
    told = statistics([error])
    return ", ".join(
        f"{axis} {told.rmse[a]:.3g} {error.unit[_KIND[axis[0]]]} ({told.rmse[a] / floor[a]:.1f} x floor)"
        for a, axis in enumerate(AXES)
        if told.rows[a] and floor[a] > 0
    )
