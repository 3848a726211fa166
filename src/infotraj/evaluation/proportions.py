"""Proportions with exact intervals."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.stats import beta


@dataclass(frozen=True)
class Proportion:
    """count of total, with a 95 % interval low..high; `bound`: the one-sided 95 % upper bound."""

    count: int
    total: int
    low: float
    high: float
    bound: float

    @property
    def share(self) -> float:
        """count / total; NaN of none."""
        return self.count / self.total if self.total else float("nan")


def proportion(count: int, total: int) -> Proportion:
    """The interval of Clopper and Pearson (1934), which holds at least as often as it says."""
    if total == 0:
        return Proportion(0, 0, 0.0, 1.0, 1.0)
    low = float(beta.ppf(0.025, count, total - count + 1)) if count else 0.0
    high, bound = (float(beta.ppf(q, count + 1, total - count)) if count < total else 1.0 for q in (0.975, 0.95))
    return Proportion(int(count), int(total), low, high, bound)


def share(count: int, total: int) -> str:
    """`18 of 20: 90 % (68 to 99)`; `-` of none."""
    p = proportion(count, total)
    if not p.total:
        return "-"
    return f"{p.count} of {p.total}: {100 * p.share:.0f} % ({100 * p.low:.0f} to {100 * p.high:.0f})"
