"""Settings that mend what `check` found, applied in rounds: each time the log is imported anew and judged again.

A finding's settings speak of the flight as it was just imported. What the mapping says already is therefore not thrown
away: a further shift or offset is added, a further scale multiplied, and further axes turned on top.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from infotraj.errors import UsageError
from infotraj.importing.frames import axes_matrix
from infotraj.importing.mapping import Mapping
from infotraj.importing.settings import Settings, merged, parse_settings, settings_text

ROUNDS = 3
_SEVERITIES = ("reject", "cut", "warning")


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
    changed: list[tuple[str, str, str]] = field(default_factory=list)
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
        try:
            left = _grave(judge(proposed))
        except UsageError:
            break  # a setting that this mapping does not take leaves the finding as it is
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


def _proposed(
    findings: Sequence[Judged], mapping: Mapping, settings: Settings
) -> tuple[Settings, list[tuple[str, str, str]]]:
    """The settings with those of all findings on top, the gravest first; of two for one key the first counts."""
    new: Settings = {}
    why = []
    for finding in sorted(findings, key=lambda f: _SEVERITIES.index(f.severity)):
        try:
            wanted = parse_settings(finding.settings)
        except UsageError:
            continue
        for channel, keys in wanted.items():
            for key, value in keys.items():
                if key in new.get(channel, {}):
                    continue
                known = settings.get(channel, {})
                old = known[key] if key in known else _declared(mapping, channel, key)
                now = _on_top(key, value, old)
                if now == old:
                    continue
                new.setdefault(channel, {})[key] = now
                why.append((*settings_text({channel: {key: now}}), finding.code, finding.what))
    return merged(settings, new), why


def _declared(mapping: Mapping, channel: str, key: str) -> Any:
    """What the first stream with the channel says."""
    mapped = next((s.channels[channel] for s in mapping.streams if channel in s.channels), None)
    return getattr(mapped, key, None)


def _on_top(key: str, value: Any, old: Any) -> Any:
    if old is None or value is None:
        return value
    try:
        if key in ("shift", "offset"):
            return round(float(old) + float(value), 9)
        if key == "scale":
            return float(f"{float(old) * float(value):.9g}")
        if key == "axes":
            return _axes(axes_matrix(value, mirrored=True) @ axes_matrix(old, mirrored=True))
    except (TypeError, ValueError):
        return value
    return value


def _axes(matrix: Any) -> list[str]:
    columns = np.argmax(np.abs(matrix), axis=1)
    return [("-" if matrix[k, c] < 0 else "") + "xyz"[c] for k, c in enumerate(columns)]
