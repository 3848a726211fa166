"""What the study of separating flights found: flights needed, and the predicted probabilities beside what came."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.evaluation.proportions import share
from infotraj.experiment.common.scores import Score, read_scores
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.separating.cases import SeparatingStudy
from infotraj.experiment.separating.loop import AGAIN, ARMS
from infotraj.plots import typeset
from infotraj.writing import write_text

ALL = "all"
EDGES = (0.0, 0.2, 0.5, 0.8, 0.95, 1.0)
OPEN = ("undecided", "group")
_DRAWS = 4000
COLUMNS = (
    "pair", "number", "hidden", "size", "task", "arm", "flight", "again", "predicted", "what", "true_odds", "warning",
)  # fmt: skip


def summarise_separating(scores: str | Path, study: SeparatingStudy, table: str | Path, markdown: str | Path) -> None:
    """Writes a row a further flight (CSV) and the page (Markdown)."""
    every = read_scores(Path(scores))
    made = flights(every)
    write_table(made, table)
    write_text(report(every, made, study), markdown)


def flights(every: Sequence[Score]) -> pd.DataFrame:
    """A row a flight after the task's, with what was predicted of it and what came."""
    rows = []
    for s in every:
        for arm in (*ARMS, AGAIN) if not s["failed"] else ():
            rows += [
                {c: s[c] for c in COLUMNS[:4]}
                | {"task": s["task"]["what"], "arm": arm, "flight": k + 1}
                | {c: step[c] for c in COLUMNS[7:]}
                for k, step in enumerate(s.get(arm, []))
            ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def needed(made: pd.DataFrame, most: int) -> pd.DataFrame:
    """Of every run the flights until the right one is told, by arm; `most` + 1 where it was not, or a wrong one was."""
    keys = ["pair", "number", "arm"]
    last = made[made["arm"].isin(ARMS)].sort_values("flight").groupby(keys, as_index=False).last()
    last["needed"] = np.where(last["what"] == "right", last["flight"], most + 1)
    return last.pivot(index=["pair", "number"], columns="arm", values="needed").reset_index()


def calibration(made: pd.DataFrame, arm: str) -> pd.DataFrame:
    """A row a bin of predicted probability: how many, their mean, and how often the odds passed and the name was
    told."""
    own = made[made["arm"] == arm]
    place = np.clip(np.digitize(own["predicted"], EDGES) - 1, 0, len(EDGES) - 2)
    rows = []
    for k in range(len(EDGES) - 1):
        part = own[place == k]
        passed, right = part["true_odds"] >= AS_PROBABLE, part["what"] == "right"
        rows.append((EDGES[k], EDGES[k + 1], len(part), part["predicted"].mean(), passed.sum(), right.sum()))
    return pd.DataFrame(rows, columns=["from", "to", "flights", "predicted", "passed", "right"])


def report(every: Sequence[Score], made: pd.DataFrame, study: SeparatingStudy) -> str:
    """The page."""
    failed = [s for s in every if s["failed"]]
    lines = ["# Which of two effects, in the study", ""]
    lines.append(
        f"{len(every)} of {study.runs * len(study.pairs)} planned runs were made, with base seed {study.base_seed}; "
        f"{len(failed)} could not be flown or answered. Shares have exact 95 % intervals (Clopper and Pearson). "
        f"Room: {' x '.join(f'{x:g}' for x in study.room.box)} m, {study.room.seconds:g} s, at most "
        f"{study.room.max_speed:g} m/s and {study.room.max_tilt:g} deg."
    )
    lines += ["", "After one flight, of the runs that the task left open:", "", _first_table(every, made)]
    lines += ["Flights until the right one is told, in the same runs:", "", _needed_table(made, study)]
    for arm in _WORDS:
        lines += [f"Predicted probability and what came, {_WORDS[arm]}:", "", _calibration_table(made, arm)]
    return "\n".join(lines)


_WORDS = {"designed": "designed flights", "random": "random deviations", AGAIN: "another flight of the task"}


def _pairs(every: Sequence[Score]) -> list[str]:
    return list(dict.fromkeys(s["pair"] for s in every))


def _first_table(every: Sequence[Score], made: pd.DataFrame) -> str:
    header = [
        "pair",
        "left open by the task",
        "designed: right",
        "wrong",
        "random: right",
        "wrong",
        "task again: right",
        "wrong",
    ]
    first = made[made["flight"] == 1]
    cells = []
    for pair in (*_pairs(every), ALL):
        own = [s for s in every if not s["failed"] and pair in (s["pair"], ALL)]
        row = [pair, f"{sum(s['task']['what'] in OPEN for s in own)} of {len(own)}"]
        for arm in _WORDS:
            part = first[(first["arm"] == arm) & ((first["pair"] == pair) | (pair == ALL))]
            row.append(share(int((part["what"] == "right").sum()), len(part)))
            row.append(str(int((part["what"] == "wrong").sum())))
        cells.append(row)
    return typeset.markdown(header, cells)


def _needed_table(made: pd.DataFrame, study: SeparatingStudy) -> str:
    most = max(study.designed, study.random)
    runs = needed(made, most)
    cells = []
    for pair in (*dict.fromkeys(runs["pair"]), ALL):
        own = runs[(runs["pair"] == pair) | (pair == ALL)]
        means = [f"{own[arm].mean():.2f}" for arm in ARMS]
        never = [str(int((own[arm] > most).sum())) for arm in ARMS]
        ratio, low, high = _ratio(own)
        cells.append([pair, str(len(own)), *means, f"{ratio:.2f} ({low:.2f} to {high:.2f})", *never])
    header = ["pair", "runs", "designed, mean", "random, mean", "designed / random (95 %, bootstrap over runs)"]
    header += [f"designed: not in {most}", f"random: not in {most}"]
    note = f"A run that was not told in {most} flights, or told wrongly, counts {most + 1}.\n"
    return typeset.markdown(header, cells) + "\n" + note


def _ratio(own: pd.DataFrame) -> tuple[float, float, float]:
    if own.empty:
        return float("nan"), float("nan"), float("nan")
    a, b = (own[arm].to_numpy(dtype=float) for arm in ARMS)
    picks = np.random.default_rng(0).integers(len(own), size=(_DRAWS, len(own)))
    low, high = np.quantile(a[picks].sum(axis=1) / b[picks].sum(axis=1), [0.025, 0.975])
    return float(a.sum() / b.sum()), float(low), float(high)


def _calibration_table(made: pd.DataFrame, arm: str) -> str:
    header = ["predicted", "flights", "mean of it", "odds of the right one passed 20 to 1", "the right one Supported"]
    cells = [
        [
            f"{100 * row['from']:.0f} to {100 * row['to']:.0f} %",
            str(int(row["flights"])),
            f"{100 * row['predicted']:.0f} %" if row["flights"] else "-",
            share(int(row["passed"]), int(row["flights"])),
            share(int(row["right"]), int(row["flights"])),
        ]
        for _, row in calibration(made, arm).iterrows()
    ]
    return typeset.markdown(header, cells)
