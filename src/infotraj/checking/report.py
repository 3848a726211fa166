"""The report of `infotraj check`: text for a reader, JSON for a program."""

from __future__ import annotations

from typing import Any

import infotraj
from infotraj.checking.across import lags_across
from infotraj.checking.finding import Finding, plain, spans_text
from infotraj.checking.whole import Check

_MARKS = {"note": "note", "warning": "WARNING", "cut": "CUT", "reject": "REJECT"}
_OUTCOMES = {
    "passed": "passed",
    "warning": "passed with a warning",
    "cut": "cut",
    "rejected": "rejected",
}


def as_json(checks: list[Check]) -> dict[str, Any]:
    """The report as docs/check.md describes it."""
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
                "coverage": plain(c.coverage),
                "cannot_answer": c.unanswerable,
                "lags": {name: {"lag": lag, "standard_error": error} for name, (lag, error) in c.lags.items()},
            }
            for c in checks
        ],
        "rejected": [c.source for c in checks if c.outcome == "rejected"],
        "across": [f.as_dict() for f in lags_across(checks)],
        "coverage": plain(covered_together(checks)),
    }


def as_text(check: Check, notes: bool = True, details: bool = False) -> str:
    """One log: a line of outcome, then a line a finding; with `details` its effect, remedy and certainty too."""
    usable = f", usable {spans_text(tuple(check.usable))}" if check.outcome == "cut" else ""
    head = (
        f"{check.source}: {_OUTCOMES[check.outcome]} ({check.rows} rows, {check.stop - check.start:.1f} s, "
        f"{check.airborne_seconds:.1f} s in the air{usable})"
    )
    lines = [head]
    for finding in check.findings:
        if finding.severity == "note" and not notes:
            continue
        lines += _lines(finding, details or finding.severity != "note")
    return "\n".join(lines)


def across_text(checks: list[Check]) -> str:
    """What several logs say together, a line a finding; empty where there is nothing to say."""
    found = lags_across(checks)
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


def _lines(finding: Finding, details: bool) -> list[str]:
    sure = "" if finding.sure >= 0.9995 else f" [sure {finding.sure:.3f}]"
    lines = [f"  {_MARKS[finding.severity]:8s}{finding.code}: {finding.what}{sure}"]
    if details:
        lines.append(f"          effect: {finding.effect}; do: {finding.remedy}")
    return lines
