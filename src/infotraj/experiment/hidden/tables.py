"""The scores of the hidden-effect study as tables: a row a run, a case, an effect against a name, a parameter."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.evaluation.proportions import proportion

NOTHING, UNEXPLAINED = "(nothing)", "(unexplained)"
ALL = "all together"
COVERED = 1.959964  # standard errors
PLAIN = {"file": "exact", "log": "clean", "gusts": False}
NAMES = ("hidden", "found", "invented", "supported", "nearest", "file_errors", "log_errors", "told_in_file")
ABOUT = ("case", "vehicle", "kind", "size", "clutter", "seed", "file", "log", "gusts")


def runs_table(paths: Sequence[Path]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """A row a run, and a row a parameter that was named with its standard error."""
    scores = [score for path in paths for score in json.loads(Path(path).read_text())]
    keys = (
        "case", "vehicle", "kind", "size", "clutter", "curve", "seed", "file", "log", "gusts", "answered", "status",
        "failed", "refusal", "right", "unexplained", "error_nominal", "error_oracle", "error_answer",
        "force_nominal", "force_answer", "wall", "cpu", "score_cpu",
    )  # fmt: skip
    rows, parameters = [], []
    for s in scores:
        row = {k: s.get(k, PLAIN.get(k)) for k in keys}
        row.update({k: "+".join(s.get(k) or []) for k in NAMES})
        groups = (s.get("stood") or {}).values()
        row["alone"], row["in_group"] = (sum((len(g) > 1) == several for g in groups) for several in (False, True))
        row["groups"] = " ".join("|".join(g) for g in s.get("groups") or [])
        rows.append(row)
        for p in s.get("parameters") or []:
            parameters.append({**{k: s.get(k, PLAIN.get(k)) for k in ABOUT}, **p})
    runs = pd.DataFrame(rows, columns=[*keys, *NAMES, "alone", "in_group", "groups"])
    for name in ("right", "unexplained", "clutter", "answered"):
        runs[name] = runs[name].fillna(False).astype(bool)
    for name in keys[keys.index("error_nominal") :]:
        runs[name] = runs[name].astype(float)
    explainable = runs["error_nominal"] - runs["error_oracle"]
    runs["fall"] = (runs["error_nominal"] - runs["error_answer"]) / explainable.where(explainable > 0.05)
    explainable = runs["force_nominal"] - 1.0
    runs["force_fall"] = (runs["force_nominal"] - runs["force_answer"]) / explainable.where(explainable > 0.05)
    runs["over_oracle"] = runs["error_answer"] / runs["error_oracle"]
    return runs, pd.DataFrame(
        parameters,
        columns=[*ABOUT, "effect", "parameter", "place", "true", "estimate", "standard_error"],
    )


def bare(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of exact files, clean logs and still air."""
    return table[(table["file"] == "exact") & (table["log"] == "clean") & ~table["gusts"].astype(bool)]


def cases_table(runs: pd.DataFrame) -> pd.DataFrame:
    """A row a case: runs, right ones with interval, invented names, unexplained, medians of the errors."""
    rows = []
    for (vehicle, kind, case), part in runs.groupby(["vehicle", "kind", "case"], sort=True):
        p = proportion(int(part["right"].sum()), len(part))
        wrong = [f"{s or NOTHING}" for s in part.loc[~part["right"], "groups"]]
        rows.append(
            {
                "vehicle": vehicle, "kind": kind, "case": case, "runs": len(part), "right": p.count, "share": p.share,
                "low": p.low, "high": p.high, "invented": int((part["invented"] != "").sum()),
                "unexplained": int(part["unexplained"].sum()), "not_answered": int((~part["answered"]).sum()),
                "error_nominal": part["error_nominal"].median(), "error_oracle": part["error_oracle"].median(),
                "error_answer": part["error_answer"].median(), "fall": part["fall"].median(),
                "wrong_answers": "; ".join(sorted(set(wrong))),
            }
        )  # fmt: skip
    return pd.DataFrame(rows)


def confusion_table(runs: pd.DataFrame) -> pd.DataFrame:
    """Shares of runs: rows what was hidden alone (usual size) or not listed, columns what was named."""
    runs = bare(runs)
    shown = runs[(runs["kind"].isin(["single", "nothing", "richer", "unlisted", "cannot_show"])) & runs["answered"]]
    shown = shown[shown["size"].isin(["", "usual"])]
    rows = []
    for (vehicle, kind, hidden), part in shown.groupby(["vehicle", "kind", "hidden"], sort=True):
        counts: dict[str, float] = {}
        for run in part.itertuples():
            names = run.supported.split("+") if run.supported else []
            if run.hidden and run.hidden in run.found.split("+"):
                # a group that holds the hidden effect counts as its name
                names = [run.hidden, *(n for n in run.invented.split("+") if n)]
            for name in names or [NOTHING]:
                counts[name] = counts.get(name, 0) + 1 / len(part)
            if run.unexplained:
                counts[UNEXPLAINED] = counts.get(UNEXPLAINED, 0) + 1 / len(part)
        rows += [
            {"vehicle": vehicle, "kind": kind, "hidden": hidden or NOTHING, "runs": len(part), "named": n, "share": v}
            for n, v in sorted(counts.items())
        ]
    return pd.DataFrame(rows, columns=["vehicle", "kind", "hidden", "runs", "named", "share"])


def coverage_table(parameters: pd.DataFrame) -> pd.DataFrame:
    """A row a parameter (all numbers of a vector): coverage of the 95 % interval, and how far estimates are off."""
    rows = []
    keys = ["vehicle", "effect", "parameter", "clutter", "file", "log", "gusts"]
    for key, part in parameters.groupby(keys, sort=True):
        off = (part["estimate"] - part["true"]).to_numpy()
        inside = np.abs(off) <= COVERED * part["standard_error"].to_numpy()
        p = proportion(int(inside.sum()), len(part))
        size = float(np.sqrt(np.mean(part["true"] ** 2)))
        rows.append(
            {
                **dict(zip(keys, key, strict=True)), "numbers": len(part),
                "covered": p.share, "low": p.low, "high": p.high, "bias": float(off.mean()),
                "rms_error": float(np.sqrt(np.mean(off**2))), "rms_true": size,
                "mean_standard_error": float(part["standard_error"].mean()),
            }
        )  # fmt: skip
    return pd.DataFrame(rows)


def curves_table(runs: pd.DataFrame) -> pd.DataFrame:
    """A row a point of a curve: share of runs in which the hidden effect was named rightly, with its interval.

    The usual case (16 s, usual noise, full log, size 1) joins every curve from the clean runs at usual size. The effect
    ALL joins the effects of a vehicle.
    """
    rows = []
    curved = runs[runs["kind"] == "curve"]
    for (vehicle, hidden, curve), part in curved.groupby(["vehicle", "hidden", "curve"], sort=True):
        what, _, value = curve.partition("=")
        rows.append(_point(vehicle, hidden, what, value, part))
    runs = bare(runs)
    usual = runs[(runs["kind"] == "single") & (runs["size"] == "usual") & ~runs["clutter"]]
    for vehicle, hidden in sorted(set(zip(curved["vehicle"], curved["hidden"], strict=True))):
        part = usual[(usual["vehicle"] == vehicle) & (usual["hidden"] == hidden)]
        if len(part):
            rows += [
                _point(vehicle, hidden, what, value, part)
                for what, value in (("size", "1"), ("seconds", "16"), ("noise", "1"), ("logging", "full"))
            ]
    columns = ["vehicle", "effect", "what", "value", "runs", "share", "low", "high", "refused"]
    table = pd.DataFrame(rows, columns=columns)
    return pd.concat([table, _together(table)], ignore_index=True) if len(table) else table


def _together(points: pd.DataFrame) -> pd.DataFrame:
    """Points of all effects of a vehicle together."""
    rows = []
    for (vehicle, what, value), part in points.groupby(["vehicle", "what", "value"], sort=False):
        p = proportion(round(float((part["share"] * part["runs"]).sum())), int(part["runs"].sum()))
        rows.append(
            {
                "vehicle": vehicle, "effect": ALL, "what": what, "value": value, "runs": p.total, "share": p.share,
                "low": p.low, "high": p.high, "refused": int(part["refused"].sum()),
            }
        )  # fmt: skip
    return pd.DataFrame(rows)


def _point(vehicle: str, effect: str, what: str, value: str, part: pd.DataFrame) -> dict:
    p = proportion(int(part["right"].sum()), len(part))
    refused = int((~part["answered"]).sum())
    return {
        "vehicle": vehicle, "effect": effect, "what": what, "value": value, "runs": len(part), "share": p.share,
        "low": p.low, "high": p.high, "refused": refused,
    }  # fmt: skip
