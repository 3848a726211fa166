"""The data of a diagnosis as the page tells it: flights, what `check` said of them, what they cover."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from infotraj.checking.coverage import LIMITS
from infotraj.checking.report import in_the_way
from infotraj.checking.whole import Check
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.flight import sha256

# What stands for each question of `coverage.LIMITS`: the channel and the statistic of it.
_FROM = {
    "speed": ("speed", "q99"),
    "tilt": ("tilt", "q99"),
    "rate_x": ("wx", "rms"),
    "rate_y": ("wy", "rms"),
    "rate_z": ("wz", "rms"),
    "vertical_acceleration": ("az", "rms"),
    "height_range": ("pz", "range"),
}


def flown(found: Diagnosis, checks: Sequence[Check]) -> list[dict[str, Any]]:
    """A row a flight that was used: file, hash, rows, seconds, what was found and left out, what it covers."""
    rows = []
    by_source = {c.source: c for c in checks}
    for s in found.samples:
        source = str(s.logged.meta.get("source", "flight"))
        check = by_source.get(source)
        t = s.logged.t
        rows.append(
            {
                "path": source,
                "name": Path(source).name,
                "sha256": sha256(Path(source)) if Path(source).is_file() else None,
                "rows": len(t),
                "start": float(s.flight.t[0]),
                "seconds": float(t[-1] - t[0]),
                "airborne": check.airborne_seconds if check is not None else None,
                "outcome": check.outcome if check is not None else None,
                "findings": [_said(f) for f in check.findings] if check is not None else [],
                "left_out": {k: v for k, v in s.left_out.items() if v},
                "missing": s.reasons,
                "covers": _covers(check) if check is not None else {},
            }
        )
    return rows


def rejected(checks: Sequence[Check]) -> list[dict[str, Any]]:
    """A row a flight that was not let in, with what is in the way."""
    return [{"path": c.source, "reason": in_the_way(c)[1]} for c in checks if c.outcome == "rejected"]


def covered_questions() -> list[dict[str, Any]]:
    """What is asked of the coverage: name, unit, the least that teaches something, and about what."""
    return [{"name": n.replace("_", " "), "key": n, "least": x, "unit": u, "of": of} for n, x, u, of in LIMITS]


def _covers(check: Check) -> dict[str, float | None]:
    out: dict[str, float | None] = {}
    for key, (channel, statistic) in _FROM.items():
        entry = check.coverage.get(channel)
        if entry is None:
            out[key] = None
        elif statistic == "range":
            out[key] = float(entry["q99"] - entry["q01"])
        else:
            out[key] = float(entry[statistic])
    return out


def _said(finding: Any) -> dict[str, Any]:
    return {
        "code": finding.code,
        "severity": finding.severity,
        "what": finding.what,
        "effect": finding.effect,
        "accepted": finding.accepted,
    }
