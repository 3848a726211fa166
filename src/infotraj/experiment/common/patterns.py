"""Cases that a configuration chooses by patterns of their names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase

from infotraj.errors import UsageError, problem

_SHOWN = 5  # names that a refusal gives


def matching(names: Iterable[str], only: Sequence[str]) -> frozenset[str]:
    """The names that match one of the patterns `only`; all without any. UsageError where a pattern matches none."""
    known = list(dict.fromkeys(names))
    for pattern in only:
        if not any(fnmatchcase(name, pattern) for name in known):
            near = get_close_matches(pattern, known, _SHOWN) or known[:_SHOWN]
            raise UsageError(
                problem(f"no case matches {pattern}", f"patterns of names such as {', '.join(near)}", "Correct `only`.")
            )
    return frozenset(name for name in known if not only or any(fnmatchcase(name, pattern) for pattern in only))
