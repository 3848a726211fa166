"""`infotraj locate`: where a model fails."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from infotraj.options import (
    NumberRange,
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
    seed_option,
    verbose_option,
    window_option,
)
from infotraj.progress import waiting
from infotraj.suggested import again, quoted
from infotraj.terminal import counted, show


@click.command("locate")
@model_argument
@flights_argument
@reference_option(", whose errors stand beside, place by place.")
@window_option
@force_from_option
@click.option(
    "--least-excess",
    type=NumberRange(min=0),
    help="Squared error over the floor's square below which a place does not matter; default 0.25.",
)
@json_option
@figures_option()
@recording_option
@reading_options()
@seed_option("Of the resamples.")
@quiet_option
@verbose_option("All windows, trees and flights.")
def locate_command(
    model: Path,
    flights: tuple[Path, ...],
    reference: tuple[Path, ...],
    window: float | None,
    force_from: str,
    least_excess: float | None,
    json_file: Path | None,
    figures: Path | None,
    recording: Path | None,
    reading: Reading,
    seed: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Say where MODEL (a model or vehicle file) fails on FLIGHTs, in sentences, worst first."""
    import numpy as np

    from infotraj.comparing import files
    from infotraj.comparing.equation_error import WINDOW, equation_error
    from infotraj.comparing.following import derivable, say_nothing_left, tells_balance
    from infotraj.comparing.outputs import try_outputs
    from infotraj.comparing.summary import at_floor
    from infotraj.comparing.unscored import unscored
    from infotraj.locating import summary
    from infotraj.locating.healthy import beside
    from infotraj.locating.locating import locate
    from infotraj.locating.places import LEAST_EXCESS
    from infotraj.models import load_model

    try_outputs(
        {"--json": json_file, "--recording": recording},
        {"--figures": figures},
        models=[model],
        flights=flights,
        reference=reference,
    )
    files.require_order(reading.start, reading.stop)
    loaded = load_model(model)
    how: dict[str, Any] = {
        "window": window or WINDOW,
        "force_from": force_from,
        "start": reading.start,
        "stop": reading.stop,
    }

    def use(flight):
        error = equation_error(loaded, flight, **how)
        if not error.scored.any():
            what = f"{flight.meta['source']}: no row to search"
            remedy = "Leave it out."
            if derivable(flight):
                remedy = "`infotraj import` derives velocity and rates from its poses."
            elif reference and tells_balance(flight):
                remedy = "`infotraj diagnose --reference` holds its balance, taken as level, against healthy flights."
            raise unscored(what, error.reasons.values(), error.left_out, len(error.t), error.window, remedy)

    def admitted(paths, seen):
        return files.admitted(paths, loaded.vehicle, use, reading, seen)

    let_in, others = files.apart(flights, reference, admitted)
    used, usual = let_in.flights, others.flights
    with waiting(f"searching {counted(len(used), 'flight')}"):
        located = locate(
            loaded,
            used,
            rng=np.random.default_rng(seed),
            least_excess=LEAST_EXCESS if least_excess is None else least_excess,
            **how,
        )
        healthy = beside(located, loaded, usual, **how) if usual else None
    show(summary.as_text(located, verbose=verbose, healthy=healthy))
    if json_file is not None:
        files.write_json(summary.as_dict(located, healthy), json_file)
    if figures is not None:
        from infotraj.plots.places import place_figures

        with waiting("drawing"):
            drawn = place_figures(located, figures)
        for path in drawn:
            say(quiet, str(path))
    if recording is not None:
        from infotraj.comparing.statistics import worst_flight
        from infotraj.recording.wrench import record_comparison

        k = worst_flight(located.errors)
        with waiting("recording"):
            record_comparison(recording, used[k], loaded, located.errors[k])
        say(quiet, f"{recording}: {located.paths[k]}")
    files.say_unmet(reading.accept, let_in.codes)
    if at_floor(located.overall) and not located.places and healthy is None:
        say_nothing_left(model, located.paths)
        return
    options = again("diagnose", reference=healthy.paths if healthy is not None else ())
    say_next(f"infotraj diagnose {quoted(model, *located.paths)}{options}")
