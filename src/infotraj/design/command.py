"""`infotraj design`."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import click

from infotraj.errors import UsageError, problem
from infotraj.options import (
    PATH,
    NumberRange,
    Reading,
    Several,
    effects_from_option,
    figures_option,
    json_option,
    model_argument,
    quiet_option,
    reading_options,
    say,
    say_next,
    seed_option,
)
from infotraj.progress import waiting
from infotraj.suggested import again, quoted
from infotraj.terminal import counted, show


class _Seconds(click.ParamType):
    """A time: `20s`, `20`."""

    name = "seconds"

    def convert(self, value, param, ctx):
        if isinstance(value, float):
            return value
        found = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*s?\s*", str(value))
        if found is None or not 6.0 <= float(found[1]) <= 300.0:
            self.fail(f"{value!r} is no time between 6s and 300s")
        return float(found[1])


class _Box(click.ParamType):
    """Three sizes in metres: `2x2x1`."""

    name = "box"

    def convert(self, value, param, ctx):
        if isinstance(value, tuple):
            return value
        parts = re.split(r"\s*[xX]\s*", str(value).strip())
        try:
            size = tuple(float(p) for p in parts)
        except ValueError:
            size = ()
        if len(size) != 3 or not all(0.0 < s <= 1000.0 for s in size):
            self.fail(f"{value!r} is no box: three sizes in metres, such as 2x2x1")
        return size


@click.command("design")
@model_argument
@click.option(
    "--flown",
    cls=Several,
    required=True,
    type=PATH,
    metavar="FLIGHT...",
    help="The flights so far; what they leave open is asked.",
)
@click.option("--separate", nargs=2, metavar="A B", help="Two effects to be told apart (rotor_effectiveness:2).")
@click.option("--determine", metavar="A", help="The effect whose numbers are to be narrowed.")
@click.option("--within", "seconds", type=_Seconds(), default="20s", show_default=True, help="Length of the flight.")
@click.option(
    "--box", type=_Box(), default="2x2x1", show_default=True, help="Room in m, around the middle of the flights."
)
@click.option("--max-speed", type=NumberRange(min=0.1), default=2.5, show_default=True, help="Greatest speed, m/s.")
@click.option("--max-tilt", type=NumberRange(1.0, 60.0), default=25.0, show_default=True, help="Greatest lean, deg.")
@click.option("--candidates", type=click.IntRange(min=3), default=60, show_default=True, help="Motions that are tried.")
@click.option("-o", "--output", required=True, type=PATH, help="The reference (CSV).")
@figures_option("the picture")
@json_option
@effects_from_option
@reading_options(part=False)
@seed_option("Of the candidates.")
@quiet_option
def design_command(
    model: Path,
    flown: tuple[Path, ...],
    separate: tuple[str, str] | None,
    determine: str | None,
    seconds: float,
    box: tuple[float, float, float],
    max_speed: float,
    max_tilt: float,
    candidates: int,
    output: Path,
    figures: Path | None,
    json_file: Path | None,
    effects_from: tuple[Path, ...],
    reading: Reading,
    seed: int,
    quiet: bool,
) -> None:
    """The flight that tells most next, beyond what the flown ones told about MODEL (a model or vehicle file)."""
    import numpy as np

    from infotraj.comparing import files
    from infotraj.comparing.outputs import try_outputs
    from infotraj.design import report
    from infotraj.design.design import design, room_of
    from infotraj.diagnosis.diagnosis import diagnose
    from infotraj.diagnosis.gates.observing import observe
    from infotraj.models.file import read_model

    if separate and determine:
        raise UsageError(problem("--separate and --determine at once", "one question", "Leave one out."))
    try_outputs(
        {"-o": output, "--json": json_file},
        {"--figures": figures},
        models=[model],
        flights=flown,
        effects_from=effects_from,
    )
    read, _ = read_model(model, effects_from)
    let_in = files.admitted(flown, read.vehicle, lambda flight: observe(read, [flight], None, None), reading)
    with waiting(f"diagnosing {counted(len(let_in.flights), 'flight')}"):
        found = diagnose(read, let_in.flights, effects_from=effects_from, seed=seed)
    room = room_of(let_in.flights, box, seconds, max_speed, float(np.deg2rad(max_tilt)), read)
    loud = not quiet and sys.stderr.isatty()
    bar = click.progressbar(length=candidates, label="candidates", file=sys.stderr) if loud else None
    made = design(
        found,
        let_in.flights,
        room,
        separate=separate or None,
        determine=determine,
        candidates=candidates,
        seed=seed,
        progress=lambda done, of: None if bar is None else bar.update(1),
    )
    if bar is not None:
        bar.render_finish()
    show(report.as_text(made, str(output)))
    made.reference.write(output)
    if json_file is not None:
        used = [Path(str(f.meta["source"])) for f in let_in.flights]
        files.write_json(report.as_dict(made, str(output), model, used), json_file)
    if figures is not None:
        from infotraj.plots.design import design_figure

        paths = [figures / "design.pdf", figures / "design.png"]
        with waiting("drawing"):
            design_figure(made.reference, made.flown.position if made.flown else None, made.inputs, made.limits, *paths)
        for p in paths:
            say(quiet, str(p))
    files.say_unmet(reading.accept, let_in.codes + [d.code for d in found.doubts])
    named = quoted(model, *(f.meta["source"] for f in let_in.flights))
    then = f"infotraj diagnose {named} NEW_FLIGHT{again('diagnose')}"
    say_next(report.following(made, quoted(output), then))
