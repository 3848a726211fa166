"""A comparison as JSON and as text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.checking.acceptance import accepted_in, accepted_lines
from infotraj.comparing.comparison import Compared, Comparison
from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.comparing.floor import AT_FLOOR, RED
from infotraj.comparing.rollouts import MEASURES, UNITS, mean_errors
from infotraj.comparing.statistics import Statistics
from infotraj.rotations import Array

_SURE = 1.96


def as_dict(comparison: Comparison) -> dict[str, Any]:
    """The content of `--json`: the first model at the top, all models under `models`; what has no answer is null."""
    first = _of_model(comparison, comparison.models[0])
    if len(comparison.models) > 1:
        others = []
        for model, apart in zip(comparison.models[1:], comparison.differences(), strict=True):
            others.append(
                {
                    **_of_model(comparison, model),
                    "against_first": {
                        "relative_change": by_axis(apart.mean),
                        "standard_error": by_axis(apart.standard_error),
                        "blocks": apart.blocks,
                        "few_blocks": apart.few,
                    },
                }
            )
        first["models"] = [{k: v for k, v in first.items()}, *others]
    return first | {"accepted": accepted_in(comparison.flights)}


def by_axis(values: Array | Sequence[float]) -> dict[str, float | None]:
    """Six numbers under the names of their axes; null where they are not finite."""
    return {axis: number(v) for axis, v in zip(AXES, values, strict=True)}


def errors_by_axis(before: Statistics, after: Statistics) -> dict[str, dict[str, float | None]]:
    """The errors of two models one after the other, axis by axis, and the floor of the second."""
    return {"before": by_axis(before.rmse), "after": by_axis(after.rmse), "floor": by_axis(after.floor)}


def number(value: float) -> float | None:
    """A number for JSON: null where it is not finite."""
    return float(value) if math.isfinite(value) else None


def _of_model(comparison: Comparison, compared: Compared) -> dict[str, Any]:
    flights = []
    for k, (path, error) in enumerate(zip(comparison.paths, compared.errors, strict=True)):
        flights.append(
            {
                "path": path,
                "rows": int(error.scored.any(axis=1).sum()),
                **_numbers(compared.of_flight(k)),
                "force_from": error.force_from,
                "cannot_say": dict(error.reasons),
                "rows_left_out": dict(error.left_out),
                "noise_not_white": by_axis(error.red),
            }
        )
        if compared.rollouts and compared.rollouts[k].reason is not None:
            flights[-1]["no_rollouts"] = compared.rollouts[k].reason
    result = {
        "model": compared.name,
        "flights": flights,
        **_numbers(compared.overall),
        "unit": compared.errors[0].unit,
        "filter": compared.errors[0].filter,
        "remarks": list(remarks(compared.overall, compared.errors)),
    }
    if compared.rollouts:
        result["rollouts"] = mean_errors(compared.rollouts)
        result["rollout_unit"] = UNITS
        result["rollout_starts"] = {
            h.label: int(sum(r.starts[i] for r in compared.rollouts))
            for i, h in enumerate(compared.rollouts[0].horizons)
        }
        result["rollout_integrator"] = f"classical Runge-Kutta, order {compared.rollouts[0].order}, one step a row"
    return result


def _numbers(s: Statistics) -> dict[str, Any]:
    return {
        "rmse": by_axis(s.rmse),
        "floor": by_axis(s.floor),
        "bias": by_axis(s.bias),
        "explained": by_axis(s.explained),
    }


def as_text(comparison: Comparison, *, verbose: bool = False) -> str:
    """Tables for people: an axis a row, then rollouts, then what cannot be said and why. verbose: a line a flight."""
    first = comparison.models[0]
    parts = [_table_of(first, len(comparison.paths))]
    if verbose or 1 < len(comparison.paths) <= 12:
        parts.append(_by_flight(comparison))
    if len(comparison.models) > 1:
        parts.append(_against(comparison))
    if any(r.reason is None for r in first.rollouts):
        parts.append(_rollouts_of(comparison))
    notes = list(dict.fromkeys([*_notes(comparison), *accepted_lines(accepted_in(comparison.flights))]))
    return "\n".join([*parts, *notes]) + "\n"


def _table_of(model: Compared, flights: int) -> str:
    s, unit = model.overall, model.errors[0].unit
    head = f"{model.name}: {flights} flight{'s' * (flights != 1)}, {int(np.nanmax(s.rows))} rows"
    lines = [head, f"{'axis':<6}{'unit':<9}{'RMSE':>10}{'floor':>10}{'x floor':>9}{'bias':>11}{'explained':>11}"]
    for k, axis in enumerate(AXES):
        of = unit["force" if k < 3 else "torque"]
        if not s.rows[k]:
            lines.append(f"{axis:<6}{of:<9}{'cannot be said':>20}")
            continue
        times = s.rmse[k] / s.floor[k] if s.floor[k] > 0 else float("nan")
        lines.append(
            f"{axis:<6}{of:<9}{s.rmse[k]:>10.4g}{s.floor[k]:>10.4g} {times:>8.4g} {s.bias[k]:>10.3g}"
            f"{_percent(s.explained[k]):>11}"
        )
    return "\n".join(lines)


def at_floor(overall: Statistics) -> bool:
    """Whether the error of every axis that can be said is at its floor: nothing is left to name on these flights."""
    said = [k for k in range(len(AXES)) if overall.rows[k] and np.isfinite(overall.rmse[k])]
    return bool(said) and all(overall.rmse[k] <= AT_FLOOR * overall.floor[k] for k in said)


def healthy_dict(healthy: Comparison) -> dict[str, Any]:
    """Errors of the healthy flights for JSON: paths, and by flight and axis the RMSE and the bias."""
    first = healthy.models[0]
    every = [first.of_flight(k) for k in range(len(healthy.paths))]
    return {
        "flights": [
            {"path": path, "rmse": by_axis(s.rmse), "bias": by_axis(s.bias)}
            for path, s in zip(healthy.paths, every, strict=True)
        ]
    }


def beside(comparison: Comparison, healthy: Comparison) -> str:
    """The first model's errors beside those of healthy flights, an axis a row: how far each is from what is usual."""
    now = comparison.models[0].overall
    every = [healthy.models[0].of_flight(k) for k in range(len(healthy.paths))]
    rmse, bias = np.array([s.rmse for s in every]), np.array([s.bias for s in every])
    head = f"beside {len(every)} healthy flight{'s' * (len(every) != 1)}"
    lines = [
        head,
        f"{'axis':<6}{'RMSE':>10}{'healthy, least to most':>26}{'bias':>11}{'healthy +- from flight to flight':>35}",
    ]
    for k, axis in enumerate(AXES):
        if not np.isfinite(now.rmse[k]) or not np.isfinite(rmse[:, k]).any():
            lines.append(f"{axis:<6}{'cannot be said':>20}")
            continue
        low, high = np.nanmin(rmse[:, k]), np.nanmax(rmse[:, k])
        own = bias[np.isfinite(bias[:, k]), k]
        spread = f"{np.std(own, ddof=1):.2g}" if len(own) > 1 else "?"
        usual = f"{np.mean(own):.3g} +- {spread}"
        lines.append(f"{axis:<6}{now.rmse[k]:>10.4g}{f'{low:.4g} to {high:.4g}':>26}{now.bias[k]:>11.3g}{usual:>28}")
    return "\n".join(lines) + "\n"


def _percent(share: float) -> str:
    """A share explained; far below nothing the digits say no more."""
    if not math.isfinite(share):
        return "-"
    return f"{100 * share:.1f}%" if share > -10 else "<-1000%"


def _by_flight(comparison: Comparison) -> str:
    first = comparison.models[0]
    lines = [f"{'RMSE over the floor':<25}" + "".join(f"{axis:>9}" for axis in AXES)]
    for k, path in enumerate(comparison.paths):
        s = first.of_flight(k)
        with np.errstate(invalid="ignore", divide="ignore"):
            times = s.rmse / s.floor
        cells = "".join(f" {'-' if not math.isfinite(x) else f'{x:.4g}':>8}" for x in times)
        lines.append(f"  {Path(path).name:<23}{cells}")
    return "\n".join(lines)


def _against(comparison: Comparison) -> str:
    first = comparison.models[0]
    lines = [f"mean square against {first.name} (change in %, +- its standard error; * beyond two of them)"]
    for model, apart in zip(comparison.models[1:], comparison.differences(), strict=True):
        cells = []
        for k, axis in enumerate(AXES):
            if not math.isfinite(apart.mean[k]):
                cells.append(f"{axis} -")
                continue
            sure = "*" if abs(apart.mean[k]) > _SURE * apart.standard_error[k] else ""
            cells.append(f"{axis} {_change(apart.mean[k])} +- {_change(apart.standard_error[k], '')}{sure}")
        few = f"  (only {apart.blocks} blocks of 2 s: take it with care)" if apart.few else ""
        few = few if apart.blocks else "  (both predict no row)"
        lines.append(f"  {model.name}: " + "  ".join(cells) + few)
    return "\n".join(lines)


def _change(share: float, sign: str = "+") -> str:
    """A change of a mean square in %: that of a model that is a thousand times worse needs no decimals."""
    return f"{100 * share:{sign}.1f}" if abs(share) < 10 else f"{100 * share:{sign}.2g}"


def _rollouts_of(comparison: Comparison) -> str:
    lines = ["mean error after open loop from every recorded state"]
    labels = [h.label for h in comparison.models[0].rollouts[0].horizons]
    for model in comparison.models:
        means = mean_errors(model.rollouts)
        lines.append(f"  {model.name:<28}" + "".join(f"{label:>12}" for label in labels))
        for measure in MEASURES:
            cells = [means[measure][label] for label in labels]
            shown = "".join(f"{'-':>12}" if c is None else f"{c:>12.4g}" for c in cells)
            lines.append(f"    {measure + ' [' + UNITS[measure] + ']':<26}{shown}")
    return "\n".join(lines)


def _notes(comparison: Comparison) -> Iterable[str]:
    first = comparison.models[0]
    why: dict[str, list[str]] = {}
    for model in comparison.models:
        of = "" if model is first else f"with {model.name} "
        for path, error, said_before in zip(comparison.paths, model.errors, first.errors, strict=True):
            new = {a: r for a, r in error.reasons.items() if model is first or said_before.reasons.get(a) != r}
            for reason in dict.fromkeys(new.values()):
                axes = ", ".join(a for a, said in new.items() if said == reason)
                why.setdefault(f"{of}nothing can be said about {axes}: {reason}", []).append(path)
    for path, rolled in zip(comparison.paths, first.rollouts, strict=False):
        if rolled.reason is not None:
            why.setdefault(f"no rollouts: {rolled.reason}", []).append(path)
    for sentence, paths in why.items():
        yield f"{paths[0] if len(paths) == 1 else f'{len(paths)} flights'}: {sentence}"
    left: dict[str, int] = {}
    for error in first.errors:
        for reason, rows in error.left_out.items():
            left[reason] = left.get(reason, 0) + rows
    shown = [f"{rows} ({reason})" for reason, rows in left.items() if rows and reason != "outside --from and --to"]
    if shown:
        yield "rows left out: " + ", ".join(shown)
    yield from remarks(first.overall, first.errors)


def remarks(overall: Statistics, errors: Sequence[EquationError]) -> Iterable[str]:
    """What a reader must know before believing the numbers: noise that is not white, predictions worse than none."""
    red = np.nanmax([np.where(np.isfinite(e.red), e.red, 0.0) for e in errors], axis=0)
    coloured = [axis for k, axis in enumerate(AXES) if red[k] > RED]
    if coloured:
        yield (
            f"the noise of {', '.join(coloured)} is not white: the floor there is all that changes within "
            f"{3 * errors[0].window:.2g} s unexplained, less with a better model"
        )
    if overall.worse_than_none:
        yield (
            f"{', '.join(overall.worse_than_none)}: the prediction is worse than none; "
            "errors there say more of the log than of the model"
        )
