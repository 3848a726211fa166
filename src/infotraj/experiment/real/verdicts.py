"""The diagnoses of public real flights side by side: verdicts by effect, error on held-out flights, named models."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from infotraj.experiment.common.tables import write_table
from infotraj.plots import typeset
from infotraj.writing import write_text

_NAMED = ("Supported", "Not separable", "Plausible")
_OTHERS = ("Not needed", "Not testable here")
_DIGITS = 3
_UNITS = {"accelerometer": "accelerometer", "velocity": "motion capture's velocity"}


def summarise_diagnoses(
    *, verdicts: Sequence[Path], numbers: Sequence[Path], held_out: Sequence[Path], added: Sequence[Path],
    table: str | Path, held_out_table: str | Path, added_table: str | Path, markdown: str | Path,
) -> None:  # fmt: skip
    """Puts the tables of all data sets below each other, and writes them as Markdown for people.

    verdicts, held_out, added: tables of `real_diagnosis`, the last two of the data sets that have them; numbers: the
    JSON of each diagnosis, in the order of `verdicts`.
    """
    found, tested, named = (_joined(paths) for paths in (verdicts, held_out, added))
    for rows, path in ((found, table), (tested, held_out_table), (named, added_table)):
        write_table(rows, path)
    parts = []
    for path, rows in zip(numbers, (pd.read_csv(p, keep_default_na=False) for p in verdicts), strict=True):
        parts.append(f"## {rows['data_set'].iloc[0]}: verdicts\n\n{_verdicts(rows)}")
        parts.append(json.loads(Path(path).read_text())["verdict"]["summary"] + "\n")
    if len(tested):
        parts.append(f"## Lateral RMSE on held-out flights, each flight's mean removed (m/s^2)\n\n{_tested(tested)}")
    for name, rows in named.groupby("data_set", sort=False) if len(named) else ():
        parts.append(f"## {name}: named effects, fitted to the flights\n\n{_named(rows)}")
    write_text("\n".join(parts), markdown)


def _joined(paths: Sequence[Path]) -> pd.DataFrame:
    if not paths:
        return pd.DataFrame({"data_set": []})
    return pd.concat([pd.read_csv(p, keep_default_na=False, na_values=[""]) for p in paths], ignore_index=True)


def _verdicts(rows: pd.DataFrame) -> str:
    header = ["effect", "verdict", "group", "rise (axis)", "held-out change, 95 %", "kept", "parameters", "reason"]
    named = rows[rows["verdict"].isin(_NAMED)].copy()
    named["place"] = named["verdict"].map(_NAMED.index)
    named["rise"] = pd.to_numeric(named["rise"])
    cells = []
    for _, r in named.sort_values(["place", "rise"], ascending=[True, False]).iterrows():
        change = f"{float(r['heldout_change']):+.3f} [{float(r['low']):+.3f}, {float(r['high']):+.3f}]"
        cells.append(
            [
                r["effect"], r["verdict"], r["group"].replace("+", ", "), f"{r['rise']:.3g} ({r['axis']})", change,
                f"{float(r['selected']):.2f}", _parameters(*r[["parameters", "standard_errors", "further_instances"]]),
                r["reason"],
            ]
        )  # fmt: skip
    lines = [typeset.markdown(header, cells)]
    for verdict in _OTHERS:
        names = rows.loc[rows["verdict"] == verdict, "effect"]
        if len(names):
            lines.append(f"{verdict}: {', '.join(names)}.\n")
    return "\n".join(lines)


def _parameters(values: str, errors: str, further: str) -> str:
    texts = [_listed(json.loads(values), json.loads(errors)), *(_listed(v, {}) for v in json.loads(further))]
    return " and ".join(texts)


def _listed(values: dict[str, Any], errors: dict[str, Any]) -> str:
    texts = []
    for name, value in values.items():
        numbers = np.atleast_1d(value)
        known = np.atleast_1d(errors[name]) if name in errors else [None] * len(numbers)
        texts.append(f"{name} " + ", ".join(_with_error(v, e) for v, e in zip(numbers, known, strict=True)))
    return "; ".join(texts)


def _with_error(value: float, error: float | None) -> str:
    return f"{value:.{_DIGITS}g}" + ("" if error is None or not np.isfinite(error) else f" +- {error:.2g}")


def _tested(rows: pd.DataFrame) -> str:
    header = ["data set", "measured by", "as given", "as diagnosed", "flights better", "each flight"]
    cells = []
    for (name, source), part in rows.groupby(["data_set", "force_from"], sort=False):
        each, whole = part[part["flight"] != "all"], part[part["flight"] == "all"].iloc[0]
        better = f"{int((each['after'] < each['before']).sum())}/{len(each)}"
        listed = "; ".join(f"{r['flight']} {r['before']:.3f} to {r['after']:.3f}" for _, r in each.iterrows())
        cells.append([name, _UNITS[source], f"{whole['before']:.3f}", f"{whole['after']:.3f}", better, listed])
    return typeset.markdown(header, cells)


def _named(rows: pd.DataFrame) -> str:
    header = [
        "`infotraj add`",
        "time constant (ms)",
        "J_xx (kg m^2)",
        "J_yy (kg m^2)",
        "RMSE tx, ty (N m)",
        "at a bound",
    ]
    cells = []
    for _, r in rows.iterrows():
        cells.append(
            [
                r["effects"].replace("+", " and "),
                _with_error(1e3 * r["time_constant"], 1e3 * r["time_constant_error"]),
                *(_with_error(r[f"J_{a}"], r[f"J_{a}_error"]) for a in ("xx", "yy")),
                f"{r['rmse_tx']:.3g}, {r['rmse_ty']:.3g}",
                "" if pd.isna(r["at_bound"]) else r["at_bound"],
            ]
        )
    return typeset.markdown(header, cells)
