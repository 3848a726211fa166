"""Why nothing of a flight can be compared, and what would mend it: the vehicle file, the window, or another flight."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from infotraj.effects.channels import file_lacks
from infotraj.errors import InputError, problem

_FLIGHT = "a flight in the air with commands and measured motion"


def unscored(
    what: str,
    reasons: Iterable[str],
    left_out: Mapping[str, int],
    rows: int,
    window: float | None = None,
    remedy: str = "Leave it out.",
) -> InputError:
    """The error of a flight of which nothing is left: what the vehicle file lacks is no fault of the flight.

    what: the flight, and that nothing is left; reasons: why axes or channels cannot be answered; left_out: rows that do
    not count, by reason; rows: of the flight; window: s, of the filter, where there is one; remedy: where the flight
    itself lacks something.
    """
    reasons = list(dict.fromkeys(reasons))
    left = [f"{n} {reason}" for reason, n in left_out.items() if n]
    found = f"{what} ({'; '.join(filter(None, [', '.join(left), *reasons]))})"
    if window is not None and not reasons and sum(left_out.values()) < rows:
        longer = f"a stretch without a gap that is longer than the window of {window:g} s"
        short = f"{what} ({'; '.join([*left, 'the others hold no whole window'])})"
        return InputError(problem(short, longer, "Give a smaller --window, or more of the flight."))
    lacks = file_lacks(reasons)
    if lacks:
        return InputError(
            problem(found, f"a vehicle file with {' and '.join(lacks)}", "Add what it lacks to the file.")
        )
    return InputError(problem(found, _FLIGHT, remedy))
