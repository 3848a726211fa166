"""The report of `infotraj check`: text for a reader, JSON for a program."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import infotraj
from infotraj.checking.acceptance import marked
from infotraj.checking.across import lags_across
from infotraj.checking.codes import NEVER
from infotraj.checking.finding import Finding, plain, spans_text
from infotraj.checking.settings import mended_by_fix, of_log, remedy_of
from infotraj.checking.whole import Check

FIX = "infotraj import LOG --fix -o NEW.parquet"  # where one setting would not do
_MARKS = {"note": "note", "warning": "WARNING", "cut": "CUT", "reject": "REJECT"}
_OUTCOMES = {
    "passed": "passed",
    "warning": "passed with a warning",
    "cut": "cut",
    "rejected": "rejected",
}


def as_json(checks: list[Check], accept: Collection[str] = ()) -> dict[str, Any]:
    """The report as docs/check.md describes it. accept: codes that are overruled in what several logs say together."""
    return {
        "version": infotraj.__version__,
        "logs": [
            {
                "path": c.source,
                "outcome": c.outcome,
                "rows": c.rows,
                "start": c.start,
                "stop": c.stop,
                "airborne": {"seconds": c.airborne_seconds, "share": c.airborne_share, "judged_from": c.airborne_from},
                "usable": [list(span) for span in c.usable],
                "findings": [f.as_dict() for f in c.findings],
                "in_the_way": in_the_way(c)[0],
                "coverage": plain(c.coverage),
                "cannot_answer": c.unanswerable,
                "lags": {name: {"lag": lag, "standard_error": error} for name, (lag, error) in c.lags.items()},
                "rates": plain(c.rates),
            }
            for c in checks
        ],
        "rejected": [c.source for c in checks if c.outcome == "rejected"],
        "across": [f.as_dict() for f in marked(lags_across(checks), frozenset(accept))],
        "coverage": plain(covered_together(checks)),
    }


def as_text(check: Check, notes: bool = True, details: bool = False) -> str:
    """One log: a line of outcome, a line a finding (with `details` its effect and remedy too), what is in the way."""
    usable = f", usable {spans_text(tuple(check.usable))}" if check.outcome == "cut" else ""
    head = (
        f"{check.source}: {_OUTCOMES[check.outcome]} ({check.rows} rows, {check.stop - check.start:.1f} s, "
        f"{check.airborne_seconds:.1f} s in the air{usable})"
    )
    lines = [head]
    for finding in check.findings:
        if finding.severity == "note" and not notes:
            continue
        lines += _lines(finding, details or finding.counts != "note", check.source)
    code, what = in_the_way(check)
    said = any(f.code == code and f.counts != "note" for f in check.findings)
    stands = what if code is None else code if said else f"{code}; do: {what}"
    return "\n".join([*lines, f"  in the way of an answer: {stands}"])


def in_the_way(check: Check) -> tuple[str | None, str]:
    """What stands between a log and an answer: the code of the finding and what to do, or None and what is left out."""
    for finding in check.findings:
        if finding.counts == "reject":
            overrule = "" if finding.code in NEVER else f", or --accept {finding.code}"
            return finding.code, of_log(_remedy(check, finding), check.source) + overrule
    unsaid = [name for name in ("force errors", "torque errors") if name in check.unanswerable]
    if len(unsaid) == 2:
        needed = sorted({column for name in unsaid for column in check.unanswerable[name]})
        return "cannot_answer", f"map {', '.join(needed)}"
    cuts = list(dict.fromkeys(f.code for f in check.findings if f.counts == "cut"))
    return None, f"nothing, without what is cut ({', '.join(cuts)})" if cuts else "nothing"


def _remedy(check: Check, finding: Finding) -> str:
    several = [f for f in check.findings if f.counts != "note" and mended_by_fix(f)]
    return FIX if finding in several and len(several) > 1 else remedy_of(finding)


def across_text(checks: list[Check], accept: Collection[str] = ()) -> str:
    """What several logs say together, a line a finding; empty for nothing to say. accept: as in `as_json`."""
    found = marked(lags_across(checks), frozenset(accept))
    return "\n".join(["all logs:", *(line for f in found for line in _lines(f, True))]) if found else ""


def covered_together(checks: list[Check]) -> dict[str, dict[str, float]]:
    """The widest range that any log that was not rejected covers, channel by channel."""
    out: dict[str, dict[str, float]] = {}
    for check in checks:
        if check.outcome == "rejected":
            continue
        for name, entry in check.coverage.items():
            known = out.setdefault(name, {"q01": entry["q01"], "q99": entry["q99"], "rms": entry["rms"]})
            known["q01"] = min(known["q01"], entry["q01"])
            known["q99"] = max(known["q99"], entry["q99"])
            known["rms"] = max(known["rms"], entry["rms"])
    return out


def _lines(finding: Finding, details: bool, source: str = "LOG") -> list[str]:
    sure = "" if finding.sure >= 0.9995 else f" [sure {finding.sure:.3f}]"
    said = "accepted " if finding.accepted else ""
    lines = [f"  {said}{_MARKS[finding.severity]:8s}{finding.code}: {finding.what}{sure}"]
    if details:
        overrule = f", or --accept {finding.code}" if finding.counts != "note" and finding.code not in NEVER else ""
        lines.append(f"          effect: {finding.effect}; do: {of_log(remedy_of(finding), source)}{overrule}")
    return lines
