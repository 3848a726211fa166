"""What comes after a comparison or a search for places: where nothing is left to name, another flight; where nothing
was measured, an import that derives it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from infotraj.comparing.floor import AT_FLOOR
from infotraj.flight import ATTITUDE, POSITION, RATE, VELOCITY, Flight
from infotraj.options import say_next
from infotraj.suggested import again, quoted, unused

_DERIVED = ((VELOCITY, POSITION), (RATE, ATTITUDE))  # by an import, and from what


def say_nothing_left(model: Path, flights: Sequence[str]) -> None:
    """That the error of every axis is at its floor, and the command that designs a flight which may tell more."""
    at_floor = f"every axis is within {AT_FLOOR:g} times its floor: nothing is left to name on these flights"
    click.echo(at_floor, err=True)
    say_next(f"infotraj design {quoted(model)} --flown {quoted(*flights)}{again('design')} -o {unused('ref.csv')}")


def measuring_command(flights: Sequence[Flight], model: Path) -> str:
    """What comes next where flights hold no measured force or torque.

    An import derives velocity and rates from poses. Where there is nothing to derive, `check` says what is missing.
    """
    named = quoted(*(f.meta.get("source", "flight") for f in flights))
    if any(map(derivable, flights)):
        return f"infotraj import {named} -o {unused('flights')}/"
    return f"infotraj check {named} --vehicle {quoted(model)}"


def derivable(flight: Flight) -> bool:
    """Whether an import would derive a velocity or rates that the flight has not."""
    return any(flight.has(*told) and not flight.has(*derived) for derived, told in _DERIVED)
