"""The hidden-effect study by circumstance: how wrong the file, how rough the log, clutter and gusts.

Right answers, false alarms, what states the file's or the log's own errors, names alone or in a group, and coverage.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from infotraj.evaluation.proportions import proportion
from infotraj.experiment.hidden.file_profiles import LEVELS
from infotraj.experiment.hidden.tables import COVERED, PLAIN

CLEAN = "clean"
COLUMNS = ("circumstance", "vehicle", "what", "count", "total", "share", "low", "high", "bound")
ALL = "all"


def circumstances(table: pd.DataFrame) -> pd.Series:
    """Of each row: clean, `clutter`, `gusts`, `file 3%` or `log autopilot`; several of them joined by ` + `."""

    def said(row) -> str:
        parts = ["clutter"] if row.clutter else []
        parts += ["gusts"] if row.gusts else []
        parts += [f"file {row.file}"] if row.file != PLAIN["file"] else []
        parts += [f"log {row.log}"] if row.log != PLAIN["log"] else []
        return " + ".join(parts) or CLEAN

    return pd.Series([said(row) for row in table.itertuples()], index=table.index, dtype=object)


def circumstances_table(runs: pd.DataFrame, parameters: pd.DataFrame) -> pd.DataFrame:
    """A row a circumstance, vehicle (and all together) and thing counted, with its exact 95 % interval.

    bound: one-sided, of 95 %.
    """
    rows = []
    runs = runs.assign(circumstance=circumstances(runs))
    parameters = parameters.assign(circumstance=circumstances(parameters))
    for name in dict.fromkeys(runs["circumstance"]):
        own, numbers = (t[t["circumstance"] == name] for t in (runs, parameters))
        for vehicle in (*sorted(set(own["vehicle"])), ALL):
            parts = [t if vehicle == ALL else t[t["vehicle"] == vehicle] for t in (own, numbers)]
            for what, count, total in _counts(*parts):
                p = proportion(count, total)
                rows.append((name, vehicle, what, count, total, p.share, p.low, p.high, p.bound))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _counts(runs: pd.DataFrame, parameters: pd.DataFrame) -> Iterator[tuple[str, int, int]]:
    """Each thing that is counted, how often it is so, and of how many; left out where there was none."""
    single = runs[(runs["kind"] == "single") & (runs["size"] == "usual")]
    several = runs[runs["kind"].isin(["pair", "triple"])]
    nothing = runs[(runs["kind"] == "nothing") & runs["answered"]]
    listed = pd.concat([single, several])
    hidden = _named(listed["hidden"])
    wrong = listed[listed["file"] != PLAIN["file"]]
    inside = (parameters["estimate"] - parameters["true"]).abs() <= COVERED * parameters["standard_error"]
    found = [
        ("singles right", int(single["right"].sum()), len(single)),
        ("pairs and triples right", int(several["right"].sum()), len(several)),
        ("false alarms", int((nothing["invented"] != "").sum()), len(nothing)),
        ("file errors named as effects", int((nothing["file_errors"] != "").sum()), len(nothing)),
        ("log errors named as effects", int((nothing["log_errors"] != "").sum()), len(nothing)),
        ("named alone", int(listed["alone"].sum()), hidden),
        ("named in a group", int(listed["in_group"].sum()), hidden),
        ("told in the section on the file", _named(wrong["told_in_file"]), _named(wrong["hidden"])),
        ("numbers in their 95 % interval", int(inside.sum()), len(inside)),
    ]
    yield from (row for row in found if row[2])


def _named(joined: pd.Series) -> int:
    """How many names a column of names joined by + holds."""
    return sum(len(names.split("+")) for names in joined if names)


def false_alarm_curve(table: pd.DataFrame) -> pd.DataFrame:
    """Of `circumstances_table`: false alarms and file errors named, by how wrong the file is (per cent, 0 exact)."""
    levels = {CLEAN: 0.0, **{f"file {level}": 100.0 * s for level, s in LEVELS.items() if s}}
    shown = table[table["circumstance"].isin(levels) & table["what"].isin(_CURVES)]
    return shown.assign(off=shown["circumstance"].map(levels)).sort_values(["vehicle", "what", "off"])


_CURVES = ("false alarms", "file errors named as effects")


def said(table: pd.DataFrame) -> str:
    """One Markdown table: a row a circumstance, all vehicles together."""
    from infotraj.plots.typeset import markdown  # late: matplotlib

    own = table[table["vehicle"] == ALL]
    things = list(dict.fromkeys(own["what"]))
    rows = []
    for name, part in own.groupby("circumstance", sort=False):
        cells = {row.what: _cell(row) for row in part.itertuples()}
        rows.append([str(name), *(cells.get(what, "-") for what in things)])
    return markdown(["circumstance", *things], rows)


def _cell(row) -> str:
    high = f", at most {100 * row.bound:.1f} %" if row.what == "false alarms" else ""
    return f"{row.count} of {row.total}: {100 * row.share:.0f} %{high}" if np.isfinite(row.share) else "-"
