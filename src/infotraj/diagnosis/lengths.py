"""About how long the parts of a diagnosis take, for whoever waits: shares of the whole, as they were measured.

What comes before a search has no steady share: the first columns and swings took 4 to 47 %.
"""

from __future__ import annotations

from collections.abc import Sequence

from infotraj.flight import Flight

# From the search on, % of it with four effects in the set; weighing and naming are of one effect. Means over 13
# diagnoses of 4 to 60 s, four of made flights and nine of real ones, on 26 November 2026.
PARTS = {
    "searching": 17.0,
    "searching anew": 20.0,
    "bounds": 8.0,
    "fitted model": 2.0,
    "searching again": 5.0,
    "structure": 2.0,
    "weighing": 3.5,
    "naming": 2.5,
    "the new model": 6.5,
    "the file's numbers": 5.5,
    "judging again": 2.0,
    "errors": 3.0,
}
AGAIN = 3  # times its mean is the second search, where it comes: one in three comes
HEALTHY = "healthy: "  # before the names of the parts while healthy flights are learned
# Against healthy flights, % of a diagnosis of as many seconds as they have: three of real flights of 8 to 38 s, on
# 28 November 2026.
_LEARNING = {"searching": 12.0, "searching anew": 22.0, "bounds": 7.0, "numbers": 9.0}
_AGAINST = {
    "first columns": 11.0,
    "searching": 10.0,
    "searching anew": 12.0,
    "bounds": 1.0,
    "weighing": 10.0,
    "naming": 5.0,
    "errors": 1.0,
}


def against(flights: Sequence[Flight], healthy: Sequence[Flight]) -> dict[str, float]:
    """The parts of a diagnosis against healthy flights, from learning them on: each side in proportion to its time."""
    lasted, usual = (sum(float(f.t[-1] - f.t[0]) for f in side) for side in (flights, healthy))
    learning = {HEALTHY + name: share for name, share in _LEARNING.items()}
    return {**learning, **{name: share * lasted / max(usual, 1e-9) for name, share in _AGAINST.items()}}
