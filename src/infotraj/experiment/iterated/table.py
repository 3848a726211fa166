"""What the study of the iterated loop found: how many flights each way of choosing them needs, and how it ends."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.evaluation.proportions import share
from infotraj.experiment.common.scores import Score, read_scores
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.iterated.cases import IteratedStudy
from infotraj.experiment.iterated.loop import ARMS
from infotraj.plots import typeset
from infotraj.writing import write_text

COLUMNS = ("run", "kind", "hidden", "first", "arm", "flights", "needed", "ends", "end", "wrong_on_the_way", "last")
WORDS = {
    "designed": "`infotraj design`",
    "random": "random motions",
    "doublets": "doublets and sweeps",
    "task": "the task again",
}
_DRAWS = 4000


def summarise_iterated(scores: str | Path, study: IteratedStudy, table: str | Path, markdown: str | Path) -> None:
    """Writes a row a loop (CSV) and the page (Markdown)."""
    every = read_scores(Path(scores))
    made = loops(every, study.flights)
    write_table(made, table)
    write_text(report(every, made, study), markdown)


def loops(every: Sequence[Score], most: int) -> pd.DataFrame:
    """A row a run and arm: how many flights were flown, how many were needed, whether the loop came to an end.

    needed: flights after which what was said is right and stays right until the end; `most` + 1 where it is not. A run
    that is right after the task's flights needs none.
    """
    rows = []
    for s in every:
        for arm in ARMS if not s["failed"] else ():
            steps = [s["first"], *s[arm]]
            what = [step["what"] for step in steps]
            before = len(what) - 1
            while before >= 0 and what[before] == "right":
                before -= 1
            needed = before + 1 if before + 1 < len(what) else most + 1
            rows.append(
                {
                    "run": s["run"],
                    "kind": s["kind"],
                    "hidden": " + ".join(s["hidden"]) or "nothing",
                    "first": what[0],
                    "arm": arm,
                    "flights": len(s[arm]),
                    "needed": needed,
                    "ends": bool(steps[-1].get("ends", False)),
                    "end": what[-1],
                    "wrong_on_the_way": "wrong" in what,
                    "last": " + ".join(steps[-1]["supported"]) or "nothing",
                }
            )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def report(every: Sequence[Score], made: pd.DataFrame, study: IteratedStudy) -> str:
    """The page."""
    failed = [s for s in every if s["failed"]]
    lines = ["# Fly, diagnose, design, fly", ""]
    lines.append(
        f"{len(every)} of {sum(study.runs.values())} planned runs were made, with base seed {study.base_seed}; "
        f"{len(failed)} could not be flown or answered. Shares have exact 95 % intervals (Clopper and Pearson). "
        f"Room: {' x '.join(f'{x:g}' for x in study.room.box)} m, {study.room.seconds:g} s, at most "
        f"{study.room.max_speed:g} m/s and {study.room.max_tilt:g} deg; at most {study.flights} flights after the "
        "task's. A loop ends where nothing is open and a flight changed no name."
    )
    lines += ["", _arms_table(made, study)]
    lines += [
        f"Needed: flights after which the answer is right and stays so; {study.flights + 1} where it does not. "
        "The ratio is of sums over runs, with 95 % by bootstrap over runs.",
        "",
        "Every run, how it ended: what was said last, after how many flights.",
        "",
        _runs_table(made),
    ]
    lines += [f"- {s['run']} ({' + '.join(s['hidden']) or 'nothing'}): {s['failed']}" for s in failed]
    return "\n".join(lines).rstrip() + "\n"


def ratio(made: pd.DataFrame, arm: str) -> tuple[float, float, float]:
    """Flights needed by design over those needed by `arm`, and its interval."""
    by_run = made.pivot(index="run", columns="arm", values="needed")
    if by_run.empty:
        return float("nan"), float("nan"), float("nan")
    a, b = (by_run[x].to_numpy(dtype=float) for x in ("designed", arm))
    picks = np.random.default_rng(0).integers(len(a), size=(_DRAWS, len(a)))
    with np.errstate(divide="ignore", invalid="ignore"):
        drawn = a[picks].sum(axis=1) / b[picks].sum(axis=1)
        low, high = np.nanquantile(drawn, [0.025, 0.975])
        return float(a.sum() / b.sum()), float(low), float(high)


def _arms_table(made: pd.DataFrame, study: IteratedStudy) -> str:
    header = ["next flight by", "right after one", "right at the end", "wrong at the end", "wrong on the way"]
    header += ["needed, mean", "not right in all", "design needs, of these", "came to an end", "and right then"]
    cells = []
    for arm, words in WORDS.items():
        own = made[made["arm"] == arm]
        over = own[own["ends"]]
        row = [words, share(int((own["needed"] <= 1).sum()), len(own))]
        row.append(share(int((own["end"] == "right").sum()), len(own)))
        row += [str(int((own["end"] == "wrong").sum())), str(int(own["wrong_on_the_way"].sum()))]
        row += [f"{own['needed'].mean():.2f}", str(int((own["needed"] > study.flights).sum()))]
        middle, low, high = ratio(made, arm)
        row.append("-" if arm == "designed" else f"{middle:.2f} ({low:.2f} to {high:.2f})")
        row += [share(len(over), len(own)), share(int((over["end"] == "right").sum()), len(over))]
        cells.append(row)
    return typeset.markdown(header, cells)


def _runs_table(made: pd.DataFrame) -> str:
    cells = []
    for _, own in made.groupby("run", sort=False):
        row = own.iloc[0]
        by_arm = own.set_index("arm")
        said = [f"{_marked(by_arm.loc[a])}, {by_arm.loc[a, 'flights']}" for a in WORDS]
        cells.append([str(row["run"]), str(row["hidden"]), str(row["first"]), *said])
    return typeset.markdown(["run", "hidden", "after the task", *WORDS.values()], cells)


def _marked(row: pd.Series) -> str:
    return f"**{row['last']}**" if row["end"] == "wrong" else f"{row['end']}: {row['last']}"
