"""What comes after a comparison or a search for places: where nothing is left to name, another flight."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from infotraj.comparing.floor import AT_FLOOR
from infotraj.options import say_next
from infotraj.suggested import again, quoted, unused


def say_nothing_left(model: Path, flights: Sequence[str]) -> None:
    """That the error of every axis is at its floor, and the command that designs a flight which may tell more."""
    at_floor = f"every axis is within {AT_FLOOR:g} times its floor: nothing is left to name on these flights"
    click.echo(at_floor, err=True)
    say_next(f"infotraj design {quoted(model)} --flown {quoted(*flights)}{again('design')} -o {unused('ref.csv')}")
