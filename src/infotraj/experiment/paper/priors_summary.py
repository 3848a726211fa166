"""What the prior that knows physics was worth over all runs: errors, and paired differences with their intervals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from infotraj.evaluation.intervals import Interval, bootstrap_mean
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.paper.priors import NONE, PHYSICS
from infotraj.plots.typeset import markdown as as_markdown
from infotraj.writing import write_text

RUN = ["plant", "seed"]
ARM = ["flown", "learned", "source"]
SOURCES = {
    "first": "the first flight alone",
    "task": "the task's flight",
    "random": "a random candidate",
    "informative": "the run's choice",
}
WITHOUT, SAME, OWN = (NONE, NONE), (NONE, PHYSICS), (PHYSICS, PHYSICS)


def summarise_priors(*, tables: Sequence[str | Path], table: str | Path, markdown: str | Path) -> None:
    """Writes all rows of `experiment.paper.priors` (CSV) and the page's two tables (Markdown)."""
    rows = pd.concat([pd.read_csv(path) for path in tables], ignore_index=True)
    write_table(rows, table)
    runs = ", ".join(f"{plant} {count}" for plant, count in rows.groupby("plant")["seed"].nunique().items())
    lines = [
        f"Runs: {runs}.",
        "",
        "Error of the task in closed loop, rad/s^2: mean over the runs (worst run).",
        "",
        of_errors(rows),
        "Paired over the runs, mean over the sizes; bootstrap 95 % intervals, runs drawn within plants.",
        "",
        of_differences(rows),
    ]
    write_text("\n".join(lines), markdown)


def of_errors(rows: pd.DataFrame) -> str:
    """Markdown, a row an arm (prior that flew, prior that learned, flight), a column a data size."""
    rows = rows.assign(
        at=rows["points"].astype(str) + rows["reference"].map({"task": " points", "modified": ", larger"})
    )
    sizes = list(dict.fromkeys(rows.sort_values(["reference", "points"], ascending=[False, True])["at"]))
    lines = []
    for (flown, learned, source), part in rows.groupby(ARM, sort=False):
        cells = []
        for size in sizes:
            error = part.loc[part["at"] == size, "error"]
            cells.append("" if error.empty else f"{error.mean():.3f} ({error.max():.2f})")
        lines.append([flown, learned, SOURCES[source], *cells])
    return as_markdown(["flown with", "learned with", "flight", *sizes], lines)


def of_differences(rows: pd.DataFrame) -> str:
    """Markdown, a row a comparison: its mean, interval and unit."""
    return as_markdown(
        ["comparison", "difference", "95 % interval"],
        [
            [name, f"{found.mean:+.{digits}f}{unit}", f"{found.low:+.{digits}f} to {found.high:+.{digits}f}"]
            for name, unit, digits, found in comparisons(rows)
        ],
    )


def comparisons(rows: pd.DataFrame) -> Iterator[tuple[str, str, int, Interval]]:
    """Name, unit, digits and interval of each paired comparison; differences in rad/s^2, gains in per cent."""
    task = rows[rows["reference"] == "task"]
    wide = task.pivot_table(index=[*RUN, "points"], columns=ARM, values="error")
    sizes = sorted(task.loc[task["source"] != "first", "points"].unique())
    larger = rows[rows["reference"] == "modified"].pivot_table(index=RUN, columns=ARM, values="error")

    def difference(errors: pd.DataFrame, one: tuple[str, ...], other: tuple[str, ...]) -> Interval:
        return _interval(errors[one] - errors[other])

    yield "first flight alone: physics minus none", "", 3, difference(wide, (*OWN, "first"), (*WITHOUT, "first"))
    for source, words in SOURCES.items():
        if source == "first":
            continue
        for name, arm in (("same points", SAME), ("own flights", OWN)):
            found = difference(wide, (*arm, source), (*WITHOUT, source))
            yield f"{words}, {name}: physics minus none", "", 3, found
            found = difference(larger, (*arm, source), (*WITHOUT, source))
            yield f"{words}, {name}: physics minus none, larger figure of eight", "", 3, found
    for name, arm in (("none", WITHOUT), ("physics", OWN)):
        for other in ("random", "task"):
            found = difference(wide, (*arm, "informative"), (*arm, other))
            yield f"{name}: the run's choice minus {SOURCES[other]}", "", 3, found
        for points in sizes:
            at = wide.xs(points, level="points")
            found = difference(at, (*arm, "informative"), (*arm, "random"))
            yield f"{name}, {points} points: the run's choice minus {SOURCES['random']}", "", 3, found
        for source in ("informative", "random"):
            gain = 100.0 * (1.0 - wide[(*arm, source)] / wide[(*arm, "task")])
            yield f"{name}: gain over the task's flight, {SOURCES[source]}", " %", 1, _interval(gain)
    found = difference(wide, (*OWN, "task"), (*WITHOUT, "informative"))
    yield "physics with the task's flight minus none with the run's choice", "", 3, found
    for source in ("informative", "task"):
        gain = 100.0 * (1.0 - wide[(*OWN, source)] / wide[(*WITHOUT, "task")])
        name = f"gain of physics with {SOURCES[source]} over none with the task's flight"
        yield name, " %", 1, _interval(gain)


def _interval(values: pd.Series) -> Interval:
    """Of one number a run: the mean over the data sizes."""
    of_run = values.dropna().groupby(RUN).mean()
    return bootstrap_mean(of_run.to_numpy(), of_run.index.get_level_values("plant"))
