"""What the hidden-effect study found, beside what it must show, and what was not run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from infotraj.evaluation.proportions import Proportion, proportion
from infotraj.experiment.common.config import HiddenEffects
from infotraj.experiment.common.tables import write_table
from infotraj.experiment.hidden import circumstances as by
from infotraj.experiment.hidden import tables
from infotraj.experiment.hidden import ways as hidden_ways
from infotraj.experiment.hidden.cases import Batch, batches
from infotraj.experiment.hidden.config import read_study

KINDS = ("single", "nothing", "pair", "triple", "cannot_show", "richer", "unlisted", "curve")


def summarise(settings: HiddenEffects, scores: Sequence[Path], markdown: Path, folder: Path, figures: Path) -> None:
    """Writes Markdown, figures and the tables (CSV) runs, cases, confusion, parameters, coverage, curves, ways,
    circumstances."""
    from infotraj.plots.hidden_circumstances import figure_false_alarms
    from infotraj.plots.hidden_effects import figure_confusion, figure_curves, figure_error_fall
    from infotraj.plots.hidden_numbers import figure_numbers

    planned = batches(read_study(settings.study), settings.only, settings.seeds)
    runs, parameters = tables.runs_table(scores)
    made = {
        "runs": runs,
        "cases": tables.cases_table(runs),
        "confusion": tables.confusion_table(runs),
        "parameters": parameters,
        "coverage": tables.coverage_table(parameters),
        "curves": tables.curves_table(runs),
        "ways": hidden_ways.ways_table(scores),
        "circumstances": by.circumstances_table(runs, parameters),
    }
    for name, table in made.items():
        write_table(table, folder / f"{name}.csv")
    for path in (markdown.parent, figures):
        path.mkdir(parents=True, exist_ok=True)
    text = report(runs, parameters, planned)
    if len(runs):
        text += f"\nBy circumstance:\n\n{by.said(made['circumstances'])}"
    if len(made["ways"]):
        text += f"\nWhat users do today, on the same flights:\n\n{hidden_ways.said(made['ways'])}"
    markdown.write_text(text)
    for name, table, draw in (
        ("confusion", made["confusion"], figure_confusion),
        ("error_fall", tables.bare(runs), figure_error_fall),
        ("curves", made["curves"], figure_curves),
        ("numbers", tables.bare(parameters), figure_numbers),
        ("false_alarms", by.false_alarm_curve(made["circumstances"]), figure_false_alarms),
    ):
        if len(table):
            draw(table, figures / f"{name}.pdf", figures / f"{name}.png")


def report(runs: pd.DataFrame, parameters: pd.DataFrame, planned: Sequence[Batch]) -> str:
    """The Markdown: targets, then runs made of those planned, then the cases that went wrong."""
    lines = ["| what | must be | is (95 % interval) | runs |", "|---|---|---|---|"]
    for what, must, said, count in _targets(runs, parameters):
        lines.append(f"| {what} | {must} | {said} | {count} |")
    lines += ["", "| kind | vehicle | runs made | planned |", "|---|---|---|---|"]
    want = Counter((b.case.kind, b.case.vehicle) for b in planned for _ in b.seeds)
    have = Counter(zip(runs["kind"], runs["vehicle"], strict=True))
    for kind, vehicle in sorted(want, key=lambda k: (KINDS.index(k[0]), k[1])):
        lines.append(f"| {kind} | {vehicle} | {have[(kind, vehicle)]} | {want[(kind, vehicle)]} |")
    total, done = sum(want.values()), sum(have.values())
    lines += [
        "",
        f"{done} of {total} planned runs were made" + ("." if done >= total else f"; {total - done} were not."),
    ]
    unflown = runs[runs["failed"].fillna("") != ""]
    if len(unflown):
        lines.append(f"{len(unflown)} could not be flown: {', '.join(sorted(set(unflown['case'])))}.")
    refused = runs[(~runs["answered"]) & (runs["failed"].fillna("") == "")]
    if len(refused):
        lines.append(f"{len(refused)} were refused by the diagnosis: {', '.join(sorted(set(refused['case'])))}.")
    if len(runs):
        lines.append(
            f"CPU of a diagnosis: {runs['cpu'].median():.1f} s (median), at most {runs['cpu'].quantile(0.95):.1f} s "
            "in 95 % of the runs."
        )
    lines += ["", "Cases with wrong answers:", "", "| case | right | answers that were wrong |", "|---|---|---|"]
    cases = tables.cases_table(runs) if len(runs) else pd.DataFrame(columns=["right", "runs"])
    for c in cases[cases["right"] < cases["runs"]].itertuples():
        lines.append(f"| {c.case} | {c.right} of {c.runs} | {c.wrong_answers.replace('|', ' or ')} |")
    return "\n".join(lines) + "\n"


def _targets(runs: pd.DataFrame, parameters: pd.DataFrame) -> list[tuple[str, str, str, int]]:
    rows: list[tuple[str, str, str, int]] = []
    everything, runs = runs, tables.bare(runs)
    parameters = tables.bare(parameters)

    def rate(what: str, must: str, part: pd.DataFrame, good: pd.Series) -> None:
        rows.append((what, must, _said(proportion(int(good.sum()), len(part))), len(part)))

    single = runs[(runs["kind"] == "single") & (runs["size"] == "usual")]
    rate("single effects, usual size: right", "at least 98 %", single, single["right"])
    for clutter in (False, True):
        part = single[single["clutter"] == clutter]
        rate(f"- {'with clutter' if clutter else 'clean'}", "", part, part["right"])
    for size in ("small", "large"):
        part = runs[(runs["kind"] == "single") & (runs["size"] == size)]
        rate(f"single effects, {size}: right", "", part, part["right"])
    several = runs[runs["kind"].isin(["pair", "triple"])]
    rate("pairs and triples: all found, nothing invented", "at least 90 %", several, several["right"])
    for kind in ("pair", "triple"):
        part = runs[runs["kind"] == kind]
        rate(f"- {kind}s", "", part, part["right"])
    for vehicle in sorted(set(runs["vehicle"])):
        part = runs[(runs["kind"] == "nothing") & (runs["vehicle"] == vehicle) & runs["answered"]]
        p = proportion(int((part["invented"] != "").sum()), len(part))
        said = f"{_said(p)}; one-sided 95 % bound {100 * p.bound:.1f} %"
        rows.append((f"nothing missing, {vehicle}: false alarms", "at most 2 %", said, len(part)))
    absent = runs[runs["kind"] == "cannot_show"]
    rate("effects without a trace: nothing named", "", absent, absent["right"])
    unlisted = runs[runs["kind"] == "unlisted"]
    rate("unlisted: flagged as unexplained, nothing wrongly supported", "at least 90 %", unlisted, unlisted["right"])
    richer = runs[runs["kind"] == "richer"]
    rate("richer physics: a nearest name, and no other", "", richer, richer["right"])
    clean = parameters[~parameters["clutter"].astype(bool)]
    inside = (clean["estimate"] - clean["true"]).abs() <= tables.COVERED * clean["standard_error"]
    rate("95 % intervals that hold the true number, clean", "90 to 99 %", clean, inside)
    named = runs[runs["kind"].isin(["single", "pair", "triple"]) & runs["fall"].notna()]
    if len(named):
        gone = f"{100 * named['fall'].median():.1f} %"
        rows.append(("explainable error gone on held-out flights, median", "at least 95 %", gone, len(named)))
        over = 100 * (named["over_oracle"].median() - 1)
        rows.append(("held-out error over the oracle's, median", "within 2 %", f"{over:+.2f} %", len(named)))
    for level, right, wrong in (
        ("1%", "", ""),
        ("3%", "at least 95 %", "at most 3 %"),
        ("10%", "at least 90 %", "at most 5 %"),
    ):
        part = everything[everything["file"] == level]
        single = part[(part["kind"] == "single") & (part["size"] == "usual")]
        rate(f"files wrong by {level}: singles right", right, single, single["right"])
        nothing = part[(part["kind"] == "nothing") & part["answered"]]
        rate(f"files wrong by {level}: false alarms", wrong, nothing, nothing["invented"] != "")
    rough = everything[(everything["log"] != "clean") & everything["kind"].isin(["single", "pair", "triple"])]
    rate("rough logs: singles, pairs and triples right", "95 % of what clean ones give", rough, rough["right"])
    fast = everything[everything["vehicle"].str.startswith("agile") & (everything["kind"] == "richer")]
    fast = fast[fast["force_fall"].notna()]
    if len(fast):
        gone = f"{100 * fast['force_fall'].median():.1f} %"
        rows.append(("agile quadrotor: force error gone on faster flights, median", "at least 70 %", gone, len(fast)))
    return rows


def _said(p: Proportion) -> str:
    if not p.total:
        return "not run"
    return f"{100 * p.share:.1f} % ({100 * p.low:.1f} to {100 * p.high:.1f})"
