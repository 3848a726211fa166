"""`infotraj locate`: where a model fails."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from infotraj.errors import InputError, problem
from infotraj.options import Several, accept_option, command_steps_option


@click.command("locate")
@click.argument("model", type=click.Path(path_type=Path))
@click.argument("flights", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FLIGHT...")
@click.option(
    "--reference",
    cls=Several,
    type=click.Path(path_type=Path),
    metavar="HEALTHY...",
    help="Healthy flights of the same vehicle, whose errors stand beside, place by place.",
)
@click.option("--window", type=click.FloatRange(min=0, min_open=True), help="Of the filter, s; default 0.15.")
@click.option(
    "--force-from",
    type=click.Choice(["auto", "accelerometer", "velocity"]),
    default="auto",
    help="What the force is measured with; auto: the accelerometer where there is one.",
)
@click.option(
    "--least-excess",
    type=click.FloatRange(min=0),
    help="Squared error over the floor's square below which a place does not matter; default 0.25.",
)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="The same, for programs.")
@click.option("--figures", type=click.Path(path_type=Path), help="A folder for figures (PNG and PDF).")
@click.option("--recording", type=click.Path(path_type=Path), help="FILE.rrd: the worst flight, for the rerun viewer.")
@click.option("--from", "start", type=float, help="First t that is searched, s.")
@click.option("--to", "stop", type=float, help="Where the search stops, s.")
@command_steps_option
@accept_option
@click.option("--skip-rejected", is_flag=True, help="Go on with the other flights.")
@click.option("--seed", type=int, default=0, help="Of the resamples.")
@click.option("-q", "--quiet", is_flag=True, help="No messages.")
@click.option("-v", "--verbose", is_flag=True, help="All windows, trees and flights.")
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
    start: float | None,
    stop: float | None,
    command_steps: int | None,
    accept: tuple[str, ...],
    skip_rejected: bool,
    seed: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Say where MODEL (a model or vehicle file) fails on FLIGHTs, in sentences, worst first."""
    import numpy as np

    from infotraj.comparing import files
    from infotraj.comparing.equation_error import WINDOW, equation_error
    from infotraj.locating import summary
    from infotraj.locating.healthy import beside
    from infotraj.locating.locating import locate
    from infotraj.locating.places import LEAST_EXCESS
    from infotraj.models import load_model

    files.require_order(start, stop)
    loaded = load_model(model)
    how = {"window": window or WINDOW, "force_from": force_from, "start": start, "stop": stop}

    def use(flight):
        error = equation_error(loaded, flight, **how)
        if not error.scored.any():
            left = ", ".join(f"{v} {k}" for k, v in error.left_out.items() if v)
            why = "; ".join(dict.fromkeys(error.reasons.values())) or left or "too short for the filter's window"
            raise InputError(problem(f"{flight.meta['source']}: no row to search ({why})", "rows", "Leave it out."))

    admitted = partial(
        files.admitted,
        vehicle=loaded.vehicle,
        use=use,
        skip_rejected=skip_rejected,
        command_steps=command_steps,
        accept=accept,
        start=start,
        stop=stop,
    )
    let_in = admitted(flights)
    used = let_in.flights
    usual = admitted(reference).flights if reference else []
    located = locate(
        loaded,
        used,
        rng=np.random.default_rng(seed),
        least_excess=LEAST_EXCESS if least_excess is None else least_excess,
        **how,
    )
    healthy = beside(located, loaded, usual, **how) if usual else None
    if json_file is not None:
        files.write_json(summary.as_dict(located, healthy), json_file)
    if figures is not None:
        from infotraj.plots.places import place_figures

        for path in place_figures(located, figures):
            _say(quiet, str(path))
    if recording is not None:
        from infotraj.comparing.statistics import worst_flight
        from infotraj.recording.wrench import record_comparison

        k = worst_flight(located.errors)
        record_comparison(recording, used[k], loaded, located.errors[k])
        _say(quiet, f"{recording}: {located.paths[k]}")
    click.echo(summary.as_text(located, verbose=verbose, healthy=healthy), nl=False)
    files.say_unmet(accept, let_in.codes)
    beside_them = f" --reference {' '.join(healthy.paths)}" if healthy is not None else ""
    _say(quiet, f"next: infotraj diagnose {model} {' '.join(located.paths)}{beside_them}")


def _say(quiet: bool, line: str) -> None:
    if not quiet:
        click.echo(line, err=True)
