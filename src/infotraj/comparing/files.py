"""Reading what commands are given, through the one door that `check` keeps, and writing what they make: whole or not
at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import click

from infotraj import __version__
from infotraj.arguments import is_path
from infotraj.checking.acceptance import accepting
from infotraj.checking.admission import admitted as let_in
from infotraj.checking.admission import checked, part
from infotraj.checking.codes import known, unmet
from infotraj.checking.whole import Check
from infotraj.errors import InputError, UsageError, problem
from infotraj.flight import Flight, read_flight, stepped
from infotraj.options import Reading
from infotraj.progress import interrupted, progress
from infotraj.vehicle import Vehicle
from infotraj.writing import whole

A = TypeVar("A")
T = TypeVar("T")


@dataclass(frozen=True)
class Admitted(Generic[T]):
    """The flights that can be used, as they may be used, and what `use` made of each; checks: of all that were read."""

    flights: list[Flight]
    found: list[T]
    checks: list[Check]

    @property
    def codes(self) -> list[str]:
        """Of all that was found."""
        return [f.code for check in self.checks for f in check.findings]


def admitted(
    paths: Sequence[Path],
    vehicle: Vehicle,
    use: Callable[[Flight], T],
    reading: Reading,
    seen: dict[str, str] | None = None,
) -> Admitted[T]:
    """The flights that `check` lets through and `use` can work with. Of several the others are named on standard error.

    seen: flights that were let in before, of which none may be a copy (`checking.admission.with_copies`).
    UsageError for a code that does not exist; InputError where a flight was rejected (with `skip_rejected`: where none
    is left).
    """
    overruled = known(reading.accept)
    start, stop, steps = reading.start, reading.stop, reading.command_steps
    read: list[Flight] = []
    rejected = 0
    for path in progress(paths, "reading flight"):
        try:
            flight = accepting(read_flight(path), overruled)
            part(flight, start, stop)
            read.append(flight if steps is None else stepped(flight, steps))
        except InputError as error:
            rejected += _named(error, among=len(paths))
    flights: list[Flight] = []
    found: list[T] = []
    checks = checked(read, vehicle, start, stop, seen)
    for flight, check in progress(list(zip(read, checks, strict=True)), "preparing flight"):
        try:
            clean = let_in(flight, check)
            found.append(use(clean))
            flights.append(clean)
        except InputError as error:
            rejected += _named(error, among=len(paths))
    if rejected and not (reading.skip_rejected and flights):
        remedy = "Leave them out, or give --skip-rejected." if flights else "The lines above say what to do."
        raise InputError(problem(f"{rejected} of {len(paths)} flights rejected", "flights that can be used", remedy))
    return Admitted(flights, found, checks)


def _named(error: InputError, among: int) -> int:
    """A line for one of several flights; where there is no other, its error is that of the command."""
    if among == 1:
        raise error
    interrupted()
    click.echo(f"rejected: {error}", err=True)
    return 1


def say_unmet(accept: Sequence[str], codes: Sequence[str]) -> None:
    """A line on standard error for each accepted code that nothing had."""
    for line in unmet(known(accept), codes):
        click.echo(line, err=True)


def require_order(start: float | None, stop: float | None) -> None:
    """UsageError unless start < stop."""
    if start is not None and stop is not None and stop <= start:
        raise UsageError(problem(f"--to {stop:g} is not after --from {start:g}", "--from below --to", "Swap them."))


def apart(
    flights: Sequence[T], reference: Sequence[T], admit: Callable[[Sequence[T], dict[str, str]], A]
) -> tuple[A, A]:
    """What `admit` makes of flights (paths, or what is in memory) and of healthy ones: no flight is its own reference.

    admit: is handed flights and those that were seen before (`checking.admission.with_copies`), so that it rejects a
    copy under another name. UsageError where a file stands in both.
    """
    twice = sorted(_files(flights) & _files(reference))
    if twice:
        raise UsageError(problem(f"{twice[0]} is asked about and healthy at once", "one of them", "Leave it out."))
    seen: dict[str, str] = {}
    return admit(flights, seen), admit(reference, seen)


def _files(flights: Sequence[object]) -> set[Path]:
    return {Path(f).resolve() for f in flights if is_path(f)}


def write_json(content: dict[str, Any], path: Path) -> None:
    """Writes JSON with the version that made it, whole or not at all."""
    with whole(path) as part:
        part.write_text(json.dumps({"infotraj": __version__, **content}, indent=2, allow_nan=False) + "\n")
