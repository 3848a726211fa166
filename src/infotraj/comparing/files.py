"""Reading what `compare` and `locate` are given, and writing what they make: whole or not at all."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from infotraj.errors import InfotrajError, InputError, UsageError, problem
from infotraj.flight import Flight, read_flight, stepped

T = TypeVar("T")


def accepted(
    paths: Sequence[Path], use: Callable[[Flight], T], *, skip_rejected: bool, command_steps: int | None = None
) -> tuple[list[Flight], list[T]]:
    """The flights that can be used, with what `use` made of each. Those that cannot are named on standard error.

    command_steps: what is said of the commands of all of them (see `stepped`); None: what their metadata say.
    InputError where one was rejected (with `skip_rejected`: where none is left).
    """
    flights: list[Flight] = []
    found: list[T] = []
    rejected = 0
    for path in paths:
        try:
            flight = read_flight(path)
            flight = flight if command_steps is None else stepped(flight, command_steps)
            found.append(use(flight))
            flights.append(flight)
        except InputError as error:
            rejected += 1
            click.echo(f"rejected: {error}", err=True)
    if rejected and not (skip_rejected and flights):
        remedy = "Leave them out." if not flights else "Leave them out, or give --skip-rejected."
        raise InputError(problem(f"{rejected} of {len(paths)} flights rejected", "flights that can be used", remedy))
    return flights, found


def require_order(start: float | None, stop: float | None) -> None:
    """UsageError unless start < stop."""
    if start is not None and stop is not None and stop <= start:
        raise UsageError(problem(f"--to {stop:g} is not after --from {start:g}", "--from below --to", "Swap them."))


def write_json(content: dict[str, Any], path: Path) -> None:
    """Writes JSON, whole or not at all."""
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n")
        os.replace(part, path)
    except OSError as error:
        raise InfotrajError(
            problem(f"{path}: {error.strerror}", "a place that can be written", "Choose another.")
        ) from error
    finally:
        part.unlink(missing_ok=True)
