"""The bars of the page: how the held-out error falls, an axis each, and what each effect brings where it matters."""

from __future__ import annotations

from typing import Any

from infotraj.report.formats import prefixed


def gains(content: dict[str, Any]) -> list[dict[str, Any]]:
    """For each box: the axis on which its effects matter most beside the others, and the held-out error there."""
    fall = content["fall"]
    whole = len(fall["rmse"]) - 1
    rows = []
    for bit, box in enumerate(fall["boxes"] if fall["axes"] else []):
        without = whole ^ (1 << bit)
        axis = max(fall["axes"], key=lambda a: fall["rmse"][without][a] / max(fall["rmse"][whole][a], 1e-300))
        said = {"label": box["label"], "names": [x.split()[0] for x in box["effects"]], "corrects": box["corrects"]}
        rows.append(said | _gain(content, axis, without))
    return rows


def whole_gain(content: dict[str, Any]) -> dict[str, Any] | None:
    """The same of all that is named together, on the axis on which it takes off most; None where nothing is named."""
    fall = content["fall"]
    axes = [a for a in fall["axes"] if a not in fall["refused"]]
    if not fall["boxes"] or not axes:
        return None
    whole = len(fall["rmse"]) - 1
    return _gain(content, max(axes, key=lambda a: fall["rmse"][0][a] / max(fall["rmse"][whole][a], 1e-300)), 0)


def _gain(content: dict[str, Any], axis: str, without: int) -> dict[str, Any]:
    """The held-out error of an axis with these boxes (their bits) and with all of them."""
    fall = content["fall"]
    whole = len(fall["rmse"]) - 1
    factor, unit = prefixed(content["unit"][axis], fall["rmse"][without][axis])
    return {
        "axis": axis,
        "unit": unit,
        "before": factor * fall["rmse"][without][axis],
        "after": factor * fall["rmse"][whole][axis],
        "low": factor * fall["low"][whole][axis],
        "high": factor * fall["high"][whole][axis],
        "floor": None if fall["floor"][axis] is None else factor * fall["floor"][axis],
    }


def panel(content: dict[str, Any], axis: str) -> dict[str, Any]:
    """The bars of one axis: each step of the waterfall, then what is ticked; lengths as shares of the longest."""
    fall = content["fall"]
    top = 1.02 * max(high[axis] for high in fall["high"])
    factor, unit = prefixed(content["unit"][axis], top)
    floor = fall["floor"][axis]
    bars = [_bar(label, at, fall, axis, top, factor) for label, at in zip(fall["steps"], fall["at"], strict=True)]
    return {
        "axis": axis,
        "what": f"{'force' if axis[0] == 'f' else 'torque'} {axis[1]}",
        "unit": unit,
        "factor": factor,
        "top": top,
        "floor": None if floor is None else 100 * floor / top,
        "floor_value": None if floor is None else factor * floor,
        "refused": fall["refused"].get(axis),
        "bars": bars,
        "now": [_bar("as ticked", len(fall["rmse"]) - 1, fall, axis, top, factor)] if fall["boxes"] else [],
    }


def _bar(label: str, at: int, fall: dict[str, Any], axis: str, top: float, factor: float) -> dict[str, Any]:
    value, low, high = (fall[key][at][axis] for key in ("rmse", "low", "high"))
    return {
        "label": label,
        "share": 100 * value / top,
        "from": 100 * low / top,
        "to": 100 * high / top,
        "value": factor * value,
        "low": factor * low,
        "high": factor * high,
    }
