"""How often `check` errs over the corpus: false rejections, cuts and warnings, and known errors that it does not name.

Sources: the exact vehicles, clean and under every log profile, the kinematic flights, the plants, and all real data
sets. Settings are found on the flights of base seed 0; figures are reported on those of base seed 1, and on the real.
"""

from __future__ import annotations

import json
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from infotraj.evaluation.proportions import proportion
from infotraj.experiment.common.config import CheckCorpus
from infotraj.experiment.corpus.judging import Row, judge
from infotraj.experiment.corpus.real import real_recipes
from infotraj.experiment.corpus.recipes import Recipe, simulated_recipes
from infotraj.writing import write_text

SEVERITIES = {"rejections": "reject", "cuts": "cut", "warnings": "warning"}


def measure(settings: CheckCorpus, data_dir: str | None, threads: int = 1) -> dict[str, Any]:
    """All figures by source, with what was said falsely and what was missed. See `summary`."""
    real, absent = real_recipes(settings.real, data_dir)
    made = simulated_recipes(settings.base_seed, settings.flights)
    spoiled: Counter[str] = Counter()
    jobs: list[tuple[Recipe, int, bool]] = []
    for recipe in made:
        spoil = recipe.moving and spoiled[recipe.source] < settings.spoiled
        spoiled[recipe.source] += spoil
        jobs.append((recipe, settings.base_seed, spoil))
    jobs += [(recipe, settings.base_seed, recipe.moving) for recipe in real]
    rows: list[Row] = []
    if threads == 1:
        for job in jobs:
            rows += _told(judge(*job))
    else:
        # long ones first would be better balanced; as they come, a source's rows stay together
        with ProcessPoolExecutor(threads) as pool:
            for part in pool.map(_judge, jobs):
                rows += _told(part)
    return {"base_seed": settings.base_seed, "absent": absent, **summary(rows), "rows": rows}


def _judge(job: tuple[Recipe, int, bool]) -> list[Row]:
    return judge(*job)


def _told(rows: list[Row]) -> list[Row]:
    wrong = sum(bool(r.get("false")) or r.get("found") is False for r in rows)
    print(f"{rows[0]['source']}, {rows[0]['log']}: {len(rows)} verdicts, {wrong} wrong", file=sys.stderr, flush=True)
    return rows


def summary(rows: list[Row]) -> dict[str, Any]:
    """By source, kind (clean, rough; `real` for the data sets) and over all: counts, shares and 95 % intervals; the
    false findings by source and code with their sentences; found errors by kind of error; what could not be read."""
    groups: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        if row["part"] != "unreadable":
            for name in ("all", f"all {row['kind']}", row["source"]):
                groups[name].append(row)
    by_error: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        if row["part"] == "injected":
            by_error[row["error"]].append(row)
    return {
        "sources": {name: _figures(part) for name, part in groups.items()},
        "errors": {
            name: {kind: _share([r["found"] for r in part if r["kind"] == kind]) for kind in ("clean", "rough")}
            for name, part in by_error.items()
        },
        "false_findings": _confusion(rows),
        "missed": [{k: r[k] for k in ("source", "log", "error", "said")} for r in rows if r.get("found") is False],
        "unreadable": [
            {"source": r["source"], "log": r["log"], "why": r["why"]} for r in rows if r["part"] == "unreadable"
        ],
        "seconds": round(sum(r.get("seconds", 0.0) for r in rows), 1),
    }


def _figures(rows: list[Row]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for part in ("whole", "segment"):
        judged = [r for r in rows if r["part"] == part]
        out[part] = {
            name: _share([any(f["severity"] == severity for f in r["false"]) for r in judged])
            for name, severity in SEVERITIES.items()
        }
    out["found"] = _share([r["found"] for r in rows if r["part"] == "injected"])
    return out


def _share(hits: Iterable[bool]) -> dict[str, Any]:
    hits = list(hits)
    p = proportion(sum(hits), len(hits))
    return {"count": p.count, "of": p.total, "low": p.low, "high": p.high}


def _confusion(rows: list[Row]) -> dict[str, dict[str, Any]]:
    """{source: {code: how often in whole logs and segments, its severities, and up to three of its sentences}}."""
    out: dict[str, dict[str, Any]] = defaultdict(dict)
    for row in rows:
        for finding in row.get("false", ()):
            entry = out[row["source"]].setdefault(
                finding["code"], {"whole": 0, "segment": 0, "severities": [], "sentences": []}
            )
            entry[row["part"]] += 1
            if finding["severity"] not in entry["severities"]:
                entry["severities"].append(finding["severity"])
            if len(entry["sentences"]) < 3:
                entry["sentences"].append(f"{row['log']}, from {row['from']:g} s: {finding['what']}")
    return dict(out)


def write(result: dict[str, Any], numbers: str | Path, markdown: str | Path, *drawn: str | Path) -> None:
    """The figures as JSON, as Markdown tables, and drawn (.pdf, .png)."""
    from infotraj.plots.check_corpus import errors_of_check

    write_text(json.dumps(result, indent=1) + "\n", numbers)
    write_text(tables(result), markdown)
    errors_of_check(result["sources"], *drawn)


def tables(result: dict[str, Any]) -> str:
    """Markdown: false findings by source, errors found by kind, and which codes were raised falsely where."""
    lines = [
        "| source | whole flights | rejected | cut | warned | segments of 10 s | rejected | cut | warned | found |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, figures in result["sources"].items():
        cells = [name]
        for part in ("whole", "segment"):
            cells.append(str(figures[part]["rejections"]["of"]))
            cells += [_cell(figures[part][what], of=False) for what in SEVERITIES]
        lines.append(f"| {' | '.join([*cells, _cell(figures['found'])])} |")
    lines += ["", "| error put in | found, clean logs | found, rough logs |", "|---|---|---|"]
    for name, kinds in result["errors"].items():
        lines.append(f"| {name} | {_cell(kinds['clean'])} | {_cell(kinds['rough'])} |")
    lines += ["", "| source | said falsely | severity | whole | segments | for example |", "|---|---|---|---|---|---|"]
    for name, codes in result["false_findings"].items():
        for code, entry in codes.items():
            sentence = entry["sentences"][0].replace("|", "/")
            counts = f"{', '.join(entry['severities'])} | {entry['whole']} | {entry['segment']}"
            lines.append(f"| {name} | {code} | {counts} | {sentence} |")
    if result["unreadable"]:
        whys = Counter((r["source"], r["why"]) for r in result["unreadable"])
        said = [f"{count} of {source} ({why[:120]})" for (source, why), count in whys.items()]
        lines += ["", f"Not imported: {'; '.join(said)}."]
    return "\n".join(lines) + "\n"


def _cell(share: dict[str, Any], of: bool = True) -> str:
    if not share["of"]:
        return "-"
    if not of and share["count"] == 0:
        return f"0 (at most {100 * share['high']:.2g} %)"
    percent = f"{100 * share['count'] / share['of']:.3g} % ({100 * share['low']:.3g} to {100 * share['high']:.3g})"
    return f"{share['count']}{' of ' + str(share['of']) if of else ''}: {percent}"
