"""Settings that mend what `check` found, applied in rounds: each time the log is imported anew and judged again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from infotraj.errors import UsageError
from infotraj.importing.mapping import Mapping
from infotraj.importing.settings import Settings, merged, parse_settings, same_reading, settings_text, with_settings

ROUNDS = 3
_SEVERITIES = ("reject", "cut", "warning")
Why = tuple[str, str, str]


class Judged(Protocol):
    """What is used of a finding of `check`."""

    @property
    def code(self) -> str: ...
    @property
    def severity(self) -> str: ...
    @property
    def what(self) -> str: ...
    @property
    def settings(self) -> tuple[str, ...]: ...


@dataclass
class Fix:
    """What was changed and why (setting, code, sentence), the settings together, and the findings that are left."""

    settings: Settings = field(default_factory=dict)
    changed: list[Why] = field(default_factory=list)
    left: list[Judged] = field(default_factory=list)


def fix(judge: Callable[[Settings], Sequence[Judged]], mapping: Mapping, settings: Settings | None = None) -> Fix:
    """The settings that leave the least to find. `judge` imports with settings and gives its findings.

    At most three rounds; a round that makes nothing better is undone, and it is the last one.
    """
    done = Fix(dict(settings or {}))
    done.left = _grave(judge(done.settings))
    for _ in range(ROUNDS):
        proposed, why = _proposed(done.left, mapping, done.settings)
        if not why:
            break
        left = _grave(judge(proposed))
        if _badness(left) >= _badness(done.left):
            break
        done.settings, done.left = proposed, left
        done.changed += why
    return done


def _grave(findings: Sequence[Judged]) -> list[Judged]:
    return [f for f in findings if f.severity in _SEVERITIES]


def _badness(findings: Sequence[Judged]) -> tuple[int, ...]:
    """How many reject, cut and warn; compared in this order."""
    return tuple(sum(f.severity == severity for f in findings) for severity in _SEVERITIES)


def _proposed(findings: Sequence[Judged], mapping: Mapping, settings: Settings) -> tuple[Settings, list[Why]]:
    """The settings with those of all findings on top, the gravest first; of two for one key the first counts.

    Settings that the mapping does not take, or that change nothing, leave their finding as it is.
    """
    proposed, set_now = settings, set()
    why: list[Why] = []
    for finding in sorted(findings, key=lambda f: _SEVERITIES.index(f.severity)):
        try:
            wanted = parse_settings(finding.settings)
            taken = {
                channel: {key: value for key, value in keys.items() if (channel, key) not in set_now}
                for channel, keys in wanted.items()
            }
            changed = with_settings(mapping, merged(proposed, taken))
        except UsageError:
            continue
        if not any(taken.values()) or same_reading(changed, with_settings(mapping, proposed)):
            continue
        proposed = merged(proposed, taken)
        set_now |= {(channel, key) for channel, keys in taken.items() for key in keys}
        why += [(text, finding.code, finding.what) for text in settings_text(taken)]
    return proposed, why
