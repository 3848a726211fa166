"""How long something will still take whose parts are known beforehand, and about what share of the whole each takes."""

from __future__ import annotations

from collections.abc import Mapping

_FIRST = 0.05  # of the whole: until so much is done nothing is said
_TRUST = 2.0  # where half of what was left is done since, the new word replaces the old one
_LATE = 5.0  # s that a piece may take longer than its share, or as long as all that comes after it


class Plan:
    """Parts in their order, with lengths in any unit; times are s of one clock, given by the caller. The first word
    about a part of it begins it: what was before does not count.

    What is done so far and how long that took say how long the whole takes. What was said before is replaced the more,
    the more of what was left then is done since: one unusual part does not throw it about.
    """

    def __init__(self, lengths: Mapping[str, float]) -> None:
        self._lengths = dict(lengths)
        self._each = dict(lengths)
        self._part = next(iter(lengths))
        self._share, self._until = 0.0, 0.0
        self._begun: float | None = None
        self._passed = 0.0  # of the lengths, where it began
        self._total: float | None = None

    def pieces(self, part: str, count: int) -> None:
        """The part will be done so many times over; of one that is under way or done nothing changes."""
        names = list(self._lengths)
        begun = self._begun is not None
        if part in names and names.index(part) >= names.index(self._part) + begun:
            self._lengths[part] = count * self._each[part]

    def reached(self, part: str, done: int, of: int, now: float) -> None:
        """So many of a part's pieces, which take about as long each, are done. A part that is no part of this plan,
        or that is passed, says nothing."""
        names = list(self._lengths)
        if part not in names or names.index(part) < names.index(self._part):
            return
        share, until = (min(k / max(of, 1), 1.0) for k in (done, done + 1))
        if part == self._part and share <= self._share and self._begun is not None:
            return
        before = self._done()
        self._part, self._share, self._until = part, share, until
        if self._begun is None:
            self._begun, self._passed = now, self._done()
        else:
            self._reckon(before, now - self._begun)

    def left(self, now: float) -> float | None:
        """s until all is done; None where that cannot be said: at the beginning, and where a piece takes so much longer
        than its share that the others' say nothing."""
        if self._total is None or self._begun is None:
            return None
        expected = self._begun + self._total - now
        whole = sum(self._lengths.values())
        least = self._total * (whole - self._done(self._until)) / (whole - self._passed)
        return None if least - expected > max(least, _LATE) else max(expected, least)

    def _done(self, share: float | None = None) -> float:
        """The length of what is done, of the part that is under way this share."""
        names = list(self._lengths)
        passed = sum(self._lengths[n] for n in names[: names.index(self._part)])
        return passed + self._lengths[self._part] * (self._share if share is None else share)

    def _reckon(self, before: float, took: float) -> None:
        whole, done = sum(self._lengths.values()), self._done()
        if done - self._passed < _FIRST * whole or took <= 0.0:
            return
        total = took * (whole - self._passed) / (done - self._passed)
        if self._total is not None:
            weight = min(_TRUST * (done - before) / max(whole - before, 1e-9), 1.0)
            total = self._total ** (1.0 - weight) * total**weight
        self._total = max(total, took)
