"""A share as people read it."""

from __future__ import annotations


def percent(share: float) -> str:
    """A share (0..1) in per cent, two digits: '12 %', '0.34 %', '100 %'."""
    value = 100.0 * share
    return f"{value:.0f} %" if value >= 9.95 else f"{value:.2g} %"
