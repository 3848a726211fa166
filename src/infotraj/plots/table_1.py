"""Table I: error reduction on the modified task against no learning, the paper's numbers beside ours."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from infotraj.evaluation.intervals import bootstrap_mean
from infotraj.plots import style, typeset
from infotraj.writing import write_text

COLUMNS = ("plant", "seed", "source", "axis", "reduction")
AXES = ("x", "y", "z")
PAPER = {  # %, Table I of the paper
    "task": {"x": 38.4, "y": 41.7, "z": 23.0},
    "informative": {"x": 43.2, "y": 57.9, "z": 62.0},
}
NAMES = {
    "task": "non-informative",
    "random": "random candidate",
    "paper": "informative (the paper's cost)",
    "informative": "informative",
    "over_task": "informative minus non-informative",
    "over_random": "informative minus random",
    "over_paper": "informative minus the paper's cost",
}


def table_1(
    table: pd.DataFrame,
    *,
    csv: str | Path | None = None,
    markdown: str | Path | None = None,
    tex: str | Path | None = None,
    png: str | Path | None = None,
) -> None:
    """Writes Table I in the formats whose path is given.

    A row a run and axis: plant, seed, source (task, random, paper, informative), axis (x, y, z), reduction (%, against
    no learning).
    Intervals are 95 % bootstrap intervals over the seeds, plants as strata; the last rows pair two sources of a seed.
    InputError where a column is missing.
    """
    style.checked(table, COLUMNS, "table 1")
    summary = summarised(table)
    header, rows = _cells(summary)
    if csv is not None:
        write_text(summary.to_csv(index=False, float_format="%.6g"), csv)
    if markdown is not None:
        write_text(typeset.markdown(header, rows), markdown)
    if tex is not None:
        write_text(typeset.latex(header, rows), tex)
    if png is not None:
        style.write(lambda: draw_table_1(table), png)


def draw_table_1(table: pd.DataFrame) -> Figure:
    """The table as a figure; argument as in `table_1`."""
    header, rows = _cells(summarised(table))
    title = "Reduction of the angular acceleration error against no learning [%]; 95 % intervals over seeds"
    return typeset.draw(header, rows, [2.3, 0.85, *[1.25] * len(AXES)], title=title)


def summarised(table: pd.DataFrame) -> pd.DataFrame:
    """A row a source, plant (and all plants) and axis: paper, mean, low, high (%), runs."""
    wide = table.pivot_table(index=["plant", "seed", "axis"], columns="source", values="reduction")
    for other in ("task", "random", "paper"):
        if {other, "informative"} <= set(wide):
            wide[f"over_{other}"] = wide["informative"] - wide[other]
    long = wide.reset_index().melt(["plant", "seed", "axis"], var_name="source", value_name="reduction").dropna()
    plants = list(dict.fromkeys(table["plant"]))
    found = []
    for source in (s for s in NAMES if (long["source"] == s).any()):
        for plant in [*(["all"] if len(plants) > 1 else []), *plants]:
            for axis in AXES:
                rows = long[(long["source"] == source) & (long["axis"] == axis)]
                rows = rows if plant == "all" else rows[rows["plant"] == plant]
                if len(rows):
                    ours = bootstrap_mean(rows["reduction"].to_numpy(), rows["plant"].to_numpy())
                    found.append(
                        {"source": source, "plant": plant, "axis": axis, "paper": paper(source, axis), **vars(ours)}
                    )
    return pd.DataFrame(found)


def paper(source: str, axis: str) -> float | None:
    """What the paper reports of a source or of the difference between two, %; None where it has none."""
    if source == "over_task":
        return round(PAPER["informative"][axis] - PAPER["task"][axis], 1)
    return PAPER[source][axis] if source in PAPER else None


def _cells(summary: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    header = ["trajectory", "plant", *(f"{a}-axis [%]" for a in AXES)]
    rows = []
    for source in dict.fromkeys(summary["source"]):
        part = summary[summary["source"] == source]
        own = [[str(plant), *_ours(part[part["plant"] == plant])] for plant in dict.fromkeys(part["plant"])]
        if paper(source, "x") is not None:
            own.insert(0, ["the paper", *(f"{paper(source, a):.1f}" for a in AXES)])
        rows += [[NAMES[source] if k == 0 else "", *cells] for k, cells in enumerate(own)]
    return header, rows


def _ours(part: pd.DataFrame) -> list[str]:
    """A cell an axis: the mean with its interval."""
    found = {row.axis: f"{row.mean:.1f} [{row.low:.1f}, {row.high:.1f}]" for row in part.itertuples(index=False)}
    return [found.get(axis, "-") for axis in AXES]
