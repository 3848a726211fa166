"""What was located, as JSON and as text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from infotraj.checking.acceptance import accepted_lines
from infotraj.comparing.equation_error import AXES
from infotraj.comparing.summary import by_axis, number, remarks
from infotraj.locating import sentences
from infotraj.locating.healthy import Beside, Usual
from infotraj.locating.locating import Located
from infotraj.locating.places import Place
from infotraj.rotations import Array

MOST = 8  # places that the text names without -v


def as_dict(located: Located, healthy: Beside | None = None) -> dict[str, Any]:
    """The content of `--json`; what has no answer is null. healthy: flights whose errors stand beside."""
    content = _of_flights(located)
    if healthy is None:
        return content
    for name, usual in (("places", healthy.places), ("pairs", healthy.pairs)):
        content[name] = [p | {"reference": _usual(u)} for p, u in zip(content[name], usual, strict=True)]
    content["offsets"] = [o | {"reference": healthy.bias(o["axis"]).tolist()} for o in content["offsets"]]
    content["reference"] = {
        "flights": [
            {"path": path, "rmse": by_axis(s.rmse), "bias": by_axis(s.bias), "over_floor": by_axis(_times(s))}
            for path, s in zip(healthy.paths, healthy.by_flight, strict=True)
        ]
    }
    return content


def _of_flights(located: Located) -> dict[str, Any]:
    return {
        "places": [_place(p) for p in located.places],
        "pairs": [_place(p) for p in located.pairs],
        "windows": [
            {
                "sentence": sentences.window_sentence(w, located.paths[w.flight]),
                "path": located.paths[w.flight],
                "axis": w.axis,
                "from": w.start,
                "to": w.stop,
                "rms": w.rms,
                "ratio": number(w.ratio),
                "over_floor": w.over_floor,
                "share_of_squares": w.share,
            }
            for w in located.windows
        ],
        "tree": {axis: [sentences.leaf_sentence(axis, leaf) for leaf in tree] for axis, tree in located.trees.items()},
        "offsets": [{"axis": axis, "bias": bias, "share_of_squares": share} for axis, bias, share in located.offsets],
        "lags": [
            {
                "axis": k.axis,
                "delay": k.delay,
                "standard_error": k.standard_error,
                "share_of_squares": k.share,
                "sure": k.late,
            }
            for k in located.lags
        ],
        "flights": [
            {"path": path, "rmse": by_axis(s.rmse), "floor": by_axis(s.floor), "over_floor": by_axis(_times(s))}
            for path, s in zip(located.paths, located.by_flight, strict=True)
        ],
        "rmse": by_axis(located.overall.rmse),
        "floor": by_axis(located.overall.floor),
        "unit": located.errors[0].unit,
        "cannot_name": list(located.cannot_name),
        "filter": located.errors[0].filter,
        "remarks": list(remarks(located.overall, located.errors)),
        "accepted": list(located.accepted),
    }


def as_text(located: Located, *, verbose: bool = False, healthy: Beside | None = None) -> str:
    """Sentences, worst first; then the axes and flights they come from. healthy: flights whose errors stand beside."""
    usual = healthy.places if healthy is not None else (None,) * len(located.places)
    together = healthy.pairs if healthy is not None else (None,) * len(located.pairs)
    lines = []
    if located.places:
        lines.append("where it fails, worst first, each axis beside its mean:")
        shown = located.places if verbose else located.places[:MOST]
        for k, (p, u) in enumerate(zip(shown, usual, strict=False)):
            lines.append(f"  {k + 1}. {_below(sentences.place_lines(p))}{_beside(p, u)}")
        if len(shown) < len(located.places):
            lines.append(f"  and {len(located.places) - len(shown)} more (-v)")
    elif located.windows:
        lines.append(
            "it fails in single windows of time, beside each flight's own mean; no state or input goes with them:"
        )
        lines += _windows(located, verbose)
    else:
        lines.append(
            "no place: nothing in state, input or time holds more of the error than chance and the floor allow"
        )
    for pair, u in list(zip(located.pairs, together, strict=True))[: None if verbose else 2]:
        lines.append(f"  together: {_below(sentences.place_lines(pair))}{_beside(pair, u)}")
    if located.offsets:
        lines.append("everywhere:")
        unit = located.errors[0].unit
        for axis, bias, share in located.offsets:
            of = unit["force" if axis.startswith("f") else "torque"]
            of_healthy = "" if healthy is None else f"; {sentences.healthy_bias(healthy.bias(axis), of)}"
            lines.append(
                f"  {axis} is off by {bias:+.3g} {of} on average "
                f"({100 * share:.0f} % of all its squared error){of_healthy}"
            )
    if located.windows and located.places:
        lines.append("in time, beside each flight's own mean:")
        lines += _windows(located, verbose)
    # A place that says more of an axis than a shift in time would is not a delay.
    said = {axis: max((p.explained for p in located.places if p.axis == axis), default=0.0) for axis in AXES}
    late = [k for k in located.lags if k.late and k.share > said[k.axis]]
    if late:
        lines.append("in step with the commands, beside each flight's own mean:")
        lines += [f"  {sentences.lag_sentence(k)}" for k in late]
    for axis, tree in located.trees.items():
        if verbose or axis == located.places[0].axis:
            lines.append(f"a tree over all quantities, {axis} beside its mean:")
            lines += [f"  {sentences.leaf_sentence(axis, leaf)}" for leaf in tree]
    lines.append(f"{'RMSE over the floor':<30}" + "".join(f"{axis:>8}" for axis in AXES))
    rows = [("all flights", located.overall)]
    if verbose or 1 < len(located.paths) <= 12:
        rows += [(Path(p).name, s) for p, s in zip(located.paths, located.by_flight, strict=True)]
    if healthy is not None:
        rows += [(f"healthy: {Path(p).name}", s) for p, s in zip(healthy.paths, healthy.by_flight, strict=True)]
    for name, s in rows:
        lines.append(f"  {name:<28}" + "".join(f" {'-' if not np.isfinite(x) else f'{x:.3g}':>7}" for x in _times(s)))
    if located.cannot_name:
        lines.append(f"not searched, for the flights do not hold it: {', '.join(located.cannot_name)}")
    lines += remarks(located.overall, located.errors)
    lines += accepted_lines(located.accepted)
    return "\n".join(lines) + "\n"


def _windows(located: Located, verbose: bool) -> list[str]:
    windows = located.windows if verbose else located.windows[:3]
    return [f"  {sentences.window_sentence(w, Path(located.paths[w.flight]).name)}" for w in windows]


def _times(s) -> Array:
    with np.errstate(invalid="ignore", divide="ignore"):
        return s.rmse / s.floor


def _below(lines: list[str]) -> str:
    return "\n     ".join(lines)


def _beside(place: Place, usual: Usual | None) -> str:
    return "" if usual is None else f"\n     {sentences.healthy_sentence(place, usual)}"


def _usual(usual: Usual) -> dict[str, Any]:
    return {
        "now_rms": number(usual.now),
        "rms": [number(x) for x in usual.rms],
        "share_of_trend": [number(x) for x in usual.trend],
    }


def _place(p: Place) -> dict[str, Any]:
    at = p.region
    result = {
        "sentence": sentences.place_sentence(p),
        "axis": p.axis,
        "quantity": p.quantity.name,
        "group": p.group,
        "unit": p.quantity.unit,
        "p": p.p,
        "share_explained": p.explained,
        "excess": number(p.excess),
        "floor": p.floor,
        "hardly_told_from": list(p.alike),
    }
    if p.other is not None and p.cell is not None:
        result["other"] = p.other.name
        result["cell"] = [list(span) for span in p.cell]
    if at is not None:
        result["region"] = {
            "side": at.side,
            "threshold": at.threshold,
            "share_of_samples": at.samples,
            "share_of_squares": at.squares,
            "ratio": number(at.ratio),
            "ci95": [number(at.low), number(at.high)],
            "rms": at.inside,
        }
    if len(p.trend[0]):
        result["trend"] = {"at": p.trend[0].tolist(), "mean": p.trend[1].tolist()}
    return result
