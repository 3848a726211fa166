"""`infotraj compare`: model against measurement."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from infotraj.errors import UsageError, problem
from infotraj.options import (
    PATH,
    Reading,
    figures_option,
    flights_argument,
    force_from_option,
    json_option,
    model_argument,
    quiet_option,
    reading_options,
    recording_option,
    reference_option,
    say,
    say_next,
    verbose_option,
    window_option,
)
from infotraj.progress import waiting
from infotraj.suggested import again, quoted
from infotraj.terminal import show

if TYPE_CHECKING:
    from infotraj.comparing.equation_error import ForceFrom

THRESHOLD_PASSED = 4


@click.command("compare")
@model_argument
@flights_argument
@click.option("--against", multiple=True, type=PATH, help="Another model; may stand repeatedly.")
@reference_option(", whose errors stand beside.")
@click.option("--horizons", help="Rollouts: steps or seconds, such as 1,10,0.5s.")
@window_option
@force_from_option
@click.option("--fail-above", help="Exit status 4 above force=N,torque=NM (RMSE of the worst axis).")
@json_option
@figures_option()
@recording_option
@reading_options()
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    help="Nothing here is random; accepted so that all commands take it.",
)
@quiet_option
@verbose_option("A line a flight.")
def compare_command(
    model: Path,
    flights: tuple[Path, ...],
    against: tuple[Path, ...],
    reference: tuple[Path, ...],
    horizons: str | None,
    window: float | None,
    force_from: ForceFrom,
    fail_above: str | None,
    json_file: Path | None,
    figures: Path | None,
    recording: Path | None,
    reading: Reading,
    seed: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Compare MODEL (a model or vehicle file) with what FLIGHTs measured: errors, bias, noise floor, rollouts."""
    from infotraj.checking.acceptance import accepted_codes
    from infotraj.comparing import files, summary, thresholds
    from infotraj.comparing.comparison import Comparison, compare
    from infotraj.comparing.equation_error import WINDOW
    from infotraj.comparing.following import say_nothing_left, say_unmeasured
    from infotraj.comparing.outputs import try_outputs
    from infotraj.comparing.rollouts import parse_horizons
    from infotraj.comparing.shaken import CODE, shaken
    from infotraj.comparing.shaken import said as said_of
    from infotraj.comparing.unscored import unscored
    from infotraj.models import load_model

    try_outputs(
        {"--json": json_file, "--recording": recording},
        {"--figures": figures},
        models=[model, *against],
        flights=flights,
        reference=reference,
    )
    files.require_order(reading.start, reading.stop)
    wanted = parse_horizons(horizons) if horizons else ()
    limits = thresholds.parse_thresholds(fail_above) if fail_above else {}
    names = [str(p) for p in (model, *against)]
    if len(set(names)) < len(names):
        raise UsageError(problem("the same model twice", "different models", "Drop one."))
    models = {name: load_model(name) for name in names}

    def use(flight):
        one = compare(
            models,
            [flight],
            horizons=wanted,
            window=window or WINDOW,
            force_from=force_from,
            start=reading.start,
            stop=reading.stop,
        )
        error = one.models[0].errors[0]
        if not error.scored.any() and len(error.reasons) < 6:
            what = f"{flight.meta['source']}: no row is scored"
            raise unscored(what, error.reasons.values(), error.left_out, len(error.t), error.window)
        return one

    def admitted(paths, seen):
        return files.admitted(paths, models[str(model)].vehicle, use, reading, seen)

    def together(let_in):
        used, parts = let_in.flights, let_in.found
        return Comparison(
            tuple(str(f.meta["source"]) for f in used),
            tuple(used),
            tuple(
                type(first)(
                    first.name,
                    first.model,
                    tuple(p.models[k].errors[0] for p in parts),
                    tuple(p.models[k].rollouts[0] for p in parts) if wanted else (),
                )
                for k, first in enumerate(parts[0].models)
            ),
        )

    let_in, others = files.apart(flights, reference, admitted)
    used, comparison = let_in.flights, together(let_in)
    healthy = together(others) if reference else None
    show(summary.as_text(comparison, verbose=verbose))
    if healthy is not None:
        show(summary.beside(comparison, healthy))
    if json_file is not None:
        content = summary.as_dict(comparison)
        files.write_json(content | ({"reference": summary.healthy_dict(healthy)} if healthy else {}), json_file)
    if (figures or recording) and not any(e.scored.any() for e in comparison.models[0].errors):
        click.echo("nothing is drawn or recorded: no axis can be said", err=True)
        figures = recording = None
    if figures is not None:
        from infotraj.plots.comparison import comparison_figures

        with waiting("drawing"):
            drawn = comparison_figures(comparison, figures)
        for path in drawn:
            say(quiet, str(path))
    if recording is not None:
        from infotraj.comparing.statistics import worst_flight
        from infotraj.recording.wrench import record_comparison

        k = worst_flight(comparison.models[0].errors)
        stems = [Path(name).stem for name in names]
        called = [f"predicted by {n}" for n in (stems if len(set(stems)) == len(stems) else names)]
        errors = {name: m.errors[k] for name, m in zip(called, comparison.models, strict=True)}
        with waiting("recording"):
            record_comparison(recording, used[k], comparison.models[0].model, errors)
        say(quiet, f"{recording}: {comparison.paths[k]}")
    felt = [shaken(models[str(model)], f, reading.start, reading.stop) for f in used] if force_from == "auto" else []
    there = [(e, CODE in accepted_codes(f)) for e, f in zip(felt, used, strict=False) if e is not None]
    files.say_unmet(reading.accept, [*let_in.codes, *(CODE for _, accepted in there if accepted)])
    said = thresholds.passed(comparison.models[0], limits)
    for sentence in said:
        click.echo(f"above the threshold: {sentence}", err=True)
    named = [f.meta["source"] for f in used]
    first = comparison.models[0]
    vibration = next((e for e, accepted in there if not accepted), None)
    if vibration is not None:
        click.echo(f"{said_of(vibration)}: --force-from velocity compares with that", err=True)
    if summary.at_floor(first.overall) and vibration is None:
        say_nothing_left(model, named)
    elif not first.overall.rows.any():
        say_unmeasured(used, model, [f.meta["source"] for f in others.flights])
    else:
        options = again("locate", reference=[f.meta["source"] for f in others.flights])
        options += " --force-from velocity" if vibration is not None else ""
        say_next(f"infotraj locate {quoted(model, *named)}{options}")
    if said:
        sys.exit(THRESHOLD_PASSED)
