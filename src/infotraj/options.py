"""Options that several commands take, and what is given with them. Nothing heavy is imported here, so that a command
loads at once."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from infotraj.sparse_commands import MOST_STEPS

PATH = click.Path(path_type=Path)
Decorator = Callable[[Any], Any]


class _Finite:
    """A number that is one: neither nan nor infinite, which pass every comparison with a bound, or none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)  # type: ignore[misc]
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)  # type: ignore[attr-defined]
        return number


class Number(_Finite, click.types.FloatParamType):
    """A finite number."""


class NumberRange(_Finite, click.FloatRange):
    """A finite number within bounds."""


class Several(click.Option):
    """An option that takes all arguments up to the next option: `--reference a b c`; it may stand repeatedly, too."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **{**kwargs, "multiple": True})

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        super().add_to_parser(parser, ctx)
        for name in self.opts:
            option = parser._long_opt.get(name)
            if option is not None:
                option.process = _taking_all(option.process)


def _taking_all(process: Any) -> Any:
    def more(value: Any, state: Any) -> None:
        process(value, state)
        while state.rargs and not state.rargs[0].startswith("-"):
            process(state.rargs.pop(0), state)

    return more


@dataclass(frozen=True)
class Reading:
    """How a command reads its flights: what `reading_options` say.

    start, stop: s, the part that is used. command_steps: what is said of the commands of all flights; None: what their
    metadata say. accept: codes of findings that are overruled. skip_rejected: go on where some flights are rejected.
    """

    start: float | None = None
    stop: float | None = None
    command_steps: int | None = None
    accept: tuple[str, ...] = ()
    skip_rejected: bool = False


accept_option = click.option(
    "--accept",
    multiple=True,
    metavar="CODE[,CODE]",
    help="Findings that are shown and kept with the answer, and are in no one's way; may stand repeatedly.",
)
_PART = (
    click.option("--from", "start", type=Number(), help="First t that is used, s."),
    click.option("--to", "stop", type=Number(), help="Where use stops, s."),
)
_LET_IN = (
    click.option(
        "--command-steps",
        type=click.IntRange(min=1, max=MOST_STEPS),
        help="Steps that commands made from a row that holds them to the next; 1: held. Default: the metadata's.",
    ),
    accept_option,
    click.option("--skip-rejected", is_flag=True, help="Go on with the other flights."),
)


def reading_options(*, part: bool = True) -> Decorator:
    """--from and --to (with `part`), --command-steps, --accept and --skip-rejected, given as one `reading`."""
    options = (*_PART, *_LET_IN) if part else _LET_IN

    def decorated(command: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(command)
        def called(
            *,
            command_steps: int | None,
            accept: tuple[str, ...],
            skip_rejected: bool,
            start: float | None = None,
            stop: float | None = None,
            **others: Any,
        ) -> None:
            command(reading=Reading(start, stop, command_steps, accept, skip_rejected), **others)

        for option in reversed(options):
            called = option(called)
        return called

    return decorated


model_argument = click.argument("model", type=PATH)
flights_argument = click.argument("flights", nargs=-1, required=True, type=PATH, metavar="FLIGHT...")
effects_from_option = click.option(
    "--effects-from", multiple=True, type=PATH, help="File or folder with your own effects."
)
json_option = click.option("--json", "json_file", type=PATH, help="The numbers, for programs.")
recording_option = click.option("--recording", type=PATH, help="FILE.rrd: the worst flight, for the rerun viewer.")
window_option = click.option("--window", type=NumberRange(min=0, min_open=True), help="Of the filter, s; default 0.15.")
force_from_option = click.option(
    "--force-from",
    type=click.Choice(["auto", "accelerometer", "velocity"]),
    default="auto",
    help="What the force is measured with; auto: the accelerometer where there is one.",
)
save_model_option = click.option("--save-model", type=PATH, help="Write the model with the supported effects.")
matters_option = click.option(
    "--matters",
    type=NumberRange(min=0),
    default=0.05,
    show_default=True,
    help="Rise of the squared error, in units of the floor, below which an effect is negligible.",
)
seconds_option = click.option(
    "--seconds",
    type=NumberRange(min=1),
    default=360.0,
    show_default=True,
    help="Of all flights together that are used at most: of each the part that moves most.",
)
quiet_option = click.option("-q", "--quiet", is_flag=True, help="Only the answer, and what comes next.")


def reference_option(what: str) -> Decorator:
    """--reference; `what` these flights are for."""
    words = f"Healthy flights of the same vehicle{what}"
    return click.option("--reference", cls=Several, type=PATH, metavar="HEALTHY...", help=words)


def figures_option(what: str = "figures") -> Decorator:
    """--figures; `what` is drawn."""
    return click.option("--figures", type=PATH, help=f"A folder for {what} (PNG and PDF).")


def seed_option(of: str) -> Decorator:
    """--seed; `of` what."""
    return click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help=of)


def verbose_option(what: str) -> Decorator:
    """--verbose; `what` is added."""
    return click.option("-v", "--verbose", is_flag=True, help=what)


def say(quiet: bool, line: str) -> None:
    """A line on standard error, unless --quiet."""
    if not quiet:
        click.echo(line, err=True)


def say_next(command: str) -> None:
    """The command that comes next, on standard error: a part of the answer, with --quiet too."""
    click.echo(f"next: {command}", err=True)
