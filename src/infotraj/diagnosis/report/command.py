"""`infotraj diagnose`, `infotraj add` and `infotraj history`."""

from __future__ import annotations

from pathlib import Path

import click

from infotraj.options import (
    PATH,
    Reading,
    Several,
    effects_from_option,
    figures_option,
    flights_argument,
    json_option,
    matters_option,
    model_argument,
    quiet_option,
    reading_options,
    recording_option,
    reference_option,
    save_model_option,
    say,
    say_next,
    seconds_option,
    seed_option,
    verbose_option,
)
from infotraj.progress import waiting
from infotraj.suggested import again, quoted
from infotraj.terminal import counted, show

_SEED = seed_option("Of the resamples and surrogates.")
_VERBOSE = verbose_option("Every effect, and what the search did.")


@click.command("diagnose")
@model_argument
@flights_argument
@reference_option(": what differs from them is asked, not what the model lacks.")
@save_model_option
@matters_option
@figures_option("the waterfall")
@recording_option
@json_option
@effects_from_option
@seconds_option
@reading_options()
@_SEED
@quiet_option
@_VERBOSE
def diagnose_command(
    model: Path,
    flights: tuple[Path, ...],
    reference: tuple[Path, ...],
    save_model: Path | None,
    matters: float,
    figures: Path | None,
    recording: Path | None,
    json_file: Path | None,
    effects_from: tuple[Path, ...],
    seconds: float,
    reading: Reading,
    seed: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Which named physical effect MODEL (a model or vehicle file) lacks on FLIGHTs, and how sure that is.

    With --reference: which effects changed since those flights.
    """
    from infotraj.comparing import files
    from infotraj.comparing.outputs import try_outputs
    from infotraj.diagnosis.report import following, summary
    from infotraj.diagnosis.report.asking import ask

    try_outputs(
        {"--save-model": save_model, "--json": json_file, "--recording": recording},
        {"--figures": figures},
        models=[model],
        flights=flights,
        reference=reference,
        effects_from=effects_from,
    )
    asked = ask(
        model,
        flights,
        reference,
        save_model=save_model,
        effects_from=effects_from,
        reading=reading,
        seconds=seconds,
    )
    used = asked.flights.flights
    with waiting(f"diagnosing {counted(len(used), 'flight')}, {sum(len(f.t) for f in used)} rows"):
        found = asked.answer(matters=matters, seed=seed)
    show(summary.as_text(found, verbose=verbose))
    if json_file is not None:
        files.write_json(summary.as_dict(found), json_file)
    if save_model is not None:
        asked.save(found, save_model)
    if figures is not None:
        from infotraj.diagnosis.report.steps import steps
        from infotraj.plots.waterfall import waterfall

        paths = [figures / "waterfall.pdf", figures / "waterfall.png"]
        with waiting("drawing"):
            f = steps(found, seed=seed)
            waterfall(f.labels, f.axes, f.rmse, f.low, f.high, f.floor, f.unit, *paths, refused=found.refused)
        for path in paths:
            say(quiet, str(path))
    if recording is not None:
        from infotraj.comparing.equation_error import equation_error
        from infotraj.comparing.statistics import worst_flight
        from infotraj.recording.wrench import record_comparison

        shown = [s.flight for s in found.samples]
        models = {"the new model": found.model}
        if found.after is not found.before and found.healthy is None:
            models["the model as given"] = asked.read
        elif found.after is not found.before:
            models["the model of the healthy flights"] = found.search.observation.model([])
        with waiting("recording"):
            errors = [equation_error(found.model, f, start=reading.start, stop=reading.stop) for f in shown]
            k = worst_flight(errors)
            named = {n: equation_error(m, shown[k], start=reading.start, stop=reading.stop) for n, m in models.items()}
            record_comparison(recording, shown[k], found.model, named, found.beside)
        say(quiet, f"{recording}: {shown[k].meta.get('source')}")
    if save_model is not None and not found.judged:
        click.echo(f"{save_model} is not written: no axis could be judged", err=True)
    files.say_unmet(reading.accept, asked.flights.codes + [d.code for d in found.doubts])
    if verbose:
        for line in found.search.trail:
            click.echo(line, err=True)
    for line in following.lines(found, model, save_model):
        click.echo(line, err=True)


@click.command("add")
@model_argument
@click.argument("effects", nargs=-1, required=True, metavar="EFFECT...")
@click.option(
    "--fit",
    "flights",
    cls=Several,
    required=True,
    type=PATH,
    metavar="FLIGHT...",
    help="The flights to fit to.",
)
@click.option("-o", "--output", required=True, type=PATH, help="The new model file.")
@json_option
@effects_from_option
@reading_options()
@_SEED
@quiet_option
@_VERBOSE
def add_command(
    model: Path,
    effects: tuple[str, ...],
    flights: tuple[Path, ...],
    output: Path,
    json_file: Path | None,
    effects_from: tuple[Path, ...],
    reading: Reading,
    seed: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Add EFFECTs to MODEL, fitted to the flights, in a new model file.

    An effect with a place in a list is named with it: rotor_effectiveness:3.
    """
    from infotraj.comparing import files
    from infotraj.comparing.outputs import try_outputs
    from infotraj.diagnosis.adding import add
    from infotraj.diagnosis.report.asking import usable
    from infotraj.diagnosis.report.following import OTHERS, force_option
    from infotraj.diagnosis.report.saving import save_added
    from infotraj.models.file import read_model

    start, stop = reading.start, reading.stop
    files.require_order(start, stop)
    outputs = {"-o": output, "--json": json_file}
    try_outputs(outputs, {}, models=[model], flights=flights, effects_from=effects_from)
    read, _ = read_model(model, effects_from)
    let_in = files.admitted(flights, read.vehicle, usable(read, start, stop), reading)
    used = let_in.flights
    with waiting(f"fitting to {counted(len(used), 'flight')}"):
        made = add(read, effects, used, effects_from=effects_from, start=start, stop=stop)
    show(made.as_text())
    save_added(made, output, parent=model, flights=used, start=start, stop=stop)
    if json_file is not None:
        files.write_json(made.as_dict(), json_file)
    for label, how in made.ended.items():
        click.echo(f"{label}: {how}; {output} says so, too", err=True)
    files.say_unmet(reading.accept, [*let_in.codes, *(a["code"] for a in made.accepted)])
    named = quoted(*(f.meta["source"] for f in used))
    options = again("compare", command_steps=made.command_steps) + force_option(bool(made.notes))
    say_next(f"infotraj compare {quoted(output)} {named} --against {quoted(model)}{options}")
    click.echo(OTHERS, err=True)


@click.command("history")
@model_argument
@json_option
@quiet_option
def history_command(model: Path, json_file: Path | None, quiet: bool) -> None:
    """How the error of MODEL fell, version by version."""
    from infotraj.diagnosis.report.history import as_dict, as_text, history

    if json_file is not None:
        from infotraj.comparing.outputs import try_outputs

        try_outputs({"--json": json_file}, {}, models=[model])
    chain = history(model)
    show(as_text(chain))
    if json_file is not None:
        from infotraj.comparing import files

        files.write_json(as_dict(chain), json_file)
    say_next(f"infotraj diagnose {quoted(model)} FLIGHT...")
