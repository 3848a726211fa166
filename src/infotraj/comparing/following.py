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

_BALANCE = (
    "taken as level, these logs still tell the balance over seconds: `diagnose` holds it against the healthy flights"
)


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


def say_unmeasured(flights: Sequence[Flight], model: Path, reference: Sequence[object]) -> None:
    """What comes next where no axis can be said; reference: the healthy flights, if there are any.

    Held against those the balance of a vehicle that is taken as level says something all the same: `diagnose` asks it.
    """
    if reference and all(map(tells_balance, flights)):
        click.echo(_BALANCE, err=True)
        named = quoted(model, *(f.meta.get("source", "flight") for f in flights))
        say_next(f"infotraj diagnose {named}{again('diagnose', reference=reference)}")
    else:
        say_next(measuring_command(flights, model))


def tells_balance(flight: Flight) -> bool:
    """Whether a flight without attitude says how it moves: taken as level, its thrust carries its weight."""
    return flight.has(*VELOCITY) and not flight.has(*ATTITUDE)


def derivable(flight: Flight) -> bool:
    """Whether an import would derive a velocity or rates that the flight has not."""
    return any(flight.has(*told) and not flight.has(*derived) for derived, told in _DERIVED)
