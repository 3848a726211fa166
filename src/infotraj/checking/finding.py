"""A finding: one thing that a log says and that cannot be taken as it stands."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

Severity = Literal["note", "warning", "cut", "reject"]
Outcome = Literal["passed", "warning", "cut", "rejected"]
SEVERITIES: tuple[Severity, ...] = ("note", "warning", "cut", "reject")
Span = tuple[float, float]
SHORTEST_PIECE = 1.0


@dataclass(frozen=True)
class Finding:
    """What was found in one log.

    `code` names the kind of finding (docs/check.md lists them all); `what` is one sentence with the numbers; `spans`
    are the times it holds for, (start, stop) in s, empty for the whole log; `sure` is the probability, 0 to 1, that it
    is so; `effect` is what it does to an answer; `remedy` is what to do. `severity`: a note leaves the log as it is, a
    warning asks for a decision, a cut makes the rows in `spans` unusable, a reject makes the whole log unusable.
    `channels` names the columns concerned, `values` holds the numbers behind the sentence. `drop`: the rows in `spans`
    are not to be used (always so for a cut; a note may drop a few rows and leave the log as good as it was).
    `settings`: what would mend it on import, each "CHANNEL.KEY=VALUE" as `infotraj import --set` takes it.
    `accepted`: the user has overruled it: it is shown, and does not reject, cut or drop.
    """

    code: str
    severity: Severity
    what: str
    effect: str
    remedy: str
    sure: float = 1.0
    spans: tuple[Span, ...] = ()
    channels: tuple[str, ...] = ()
    values: dict[str, Any] = field(default_factory=dict)
    drop: bool = False
    settings: tuple[str, ...] = ()
    accepted: bool = False

    @property
    def counts(self) -> Severity:
        """The severity as it bears on what becomes of the log: an accepted finding counts as a note."""
        return "note" if self.accepted else self.severity

    @property
    def drops(self) -> bool:
        """Whether the rows in `spans` are not to be used."""
        return not self.accepted and (self.drop or self.severity == "cut")

    def as_dict(self) -> dict[str, Any]:
        """The finding as JSON holds it; numbers that are not finite become null."""
        return {
            "code": self.code,
            "severity": self.severity,
            "what": self.what,
            "accepted": self.accepted,
            "drops_rows": self.drops,
            "where": [[round(a, 4), round(b, 4)] for a, b in self.spans],
            "channels": list(self.channels),
            "sure": round(self.sure, 4),
            "effect": self.effect,
            "remedy": self.remedy,
            "settings": list(self.settings),
            "values": {key: plain(value) for key, value in self.values.items()},
        }


def outcome(findings: list[Finding]) -> Outcome:
    """The worst severity among the findings, as what becomes of the log."""
    worst = max((SEVERITIES.index(f.counts) for f in findings), default=0)
    return ("passed", "warning", "cut", "rejected")[worst]


def ordered(findings: list[Finding]) -> list[Finding]:
    """The worst first, what was accepted among the notes; within a severity in order of time, then of code."""
    return sorted(
        findings, key=lambda f: (-SEVERITIES.index(f.counts), f.spans[0][0] if f.spans else -math.inf, f.code)
    )


def usable_spans(start: float, stop: float, findings: list[Finding]) -> list[Span]:
    """What the cuts leave of start..stop (s), pieces of SHORTEST_PIECE at least; none where a finding rejects the
    log."""
    if any(f.counts == "reject" for f in findings):
        return []
    cuts = sorted(span for f in findings if f.drops for span in f.spans)
    left, at = [], start
    for a, b in cuts:
        if a > at:
            left.append((at, min(a, stop)))
        at = max(at, b)
    if at < stop:
        left.append((at, stop))
    return [(a, b) for a, b in left if b - a >= SHORTEST_PIECE]


def spans_text(spans: tuple[Span, ...], limit: int = 4) -> str:
    """`3.1..4.2 s, 5.0..5.5 s and 3 more`; empty for no span."""
    if not spans:
        return ""
    shown = ", ".join(f"{a:.2f}" if b - a < 0.005 else f"{a:.2f}..{b:.2f}" for a, b in spans[:limit])
    more = f" and {len(spans) - limit} more" if len(spans) > limit else ""
    return f"{shown} s{more}"


def plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if hasattr(value, "item"):
        value = value.item() if getattr(value, "ndim", 0) == 0 else [plain(v) for v in value.tolist()]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value
