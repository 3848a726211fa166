"""`infotraj report`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from infotraj.errors import UsageError, problem
from infotraj.options import Several, accept_option, command_steps_option


@click.command("report")
@click.argument("model", required=False, type=click.Path(path_type=Path))
@click.argument("flights", nargs=-1, type=click.Path(path_type=Path), metavar="FLIGHT...")
@click.option(
    "--reference",
    cls=Several,
    type=click.Path(path_type=Path),
    metavar="HEALTHY...",
    help="Healthy flights of the same vehicle: what differs from them is asked, not what the model lacks.",
)
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The page (HTML).")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="All that the page shows, for programs.")
@click.option(
    "--from-json", type=click.Path(path_type=Path), help="Draw the page from what --json wrote; nothing is computed."
)
@click.option("--save-model", type=click.Path(path_type=Path), help="Write the model with the supported effects.")
@click.option(
    "--matters",
    type=click.FloatRange(min=0),
    default=0.05,
    show_default=True,
    help="Rise of the squared error, in units of the floor, below which an effect is negligible.",
)
@click.option(
    "--effects-from", multiple=True, type=click.Path(path_type=Path), help="File or folder with your own effects."
)
@click.option("--from", "start", type=float, help="First t that is used, s.")
@click.option("--to", "stop", type=float, help="Where use stops, s.")
@command_steps_option
@accept_option
@click.option("--skip-rejected", is_flag=True, help="Go on with the other flights.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the resamples and surrogates.")
@click.option("-q", "--quiet", is_flag=True, help="No messages.")
def report_command(
    model: Path | None,
    flights: tuple[Path, ...],
    reference: tuple[Path, ...],
    output: Path,
    json_file: Path | None,
    from_json: Path | None,
    save_model: Path | None,
    matters: float,
    effects_from: tuple[Path, ...],
    start: float | None,
    stop: float | None,
    command_steps: int | None,
    accept: tuple[str, ...],
    skip_rejected: bool,
    seed: int,
    quiet: bool,
) -> None:
    """Diagnose MODEL on FLIGHTs as `diagnose` does, and show all of it on one HTML page that needs no network.

    \b
    infotraj report vehicle.yaml flight_*.parquet -o report.html
    infotraj report --from-json report.json -o report.html
    """
    _require_one(model, flights, from_json, (reference, json_file, save_model))
    if from_json is not None:
        from infotraj.report.again import read_content

        _write(read_content(from_json), output, quiet)
        return
    assert model is not None
    from infotraj.comparing import files
    from infotraj.diagnosis.report.asking import ask
    from infotraj.diagnosis.report.summary import sentence
    from infotraj.report.content import gathered

    _say(quiet, "reading and checking the flights")
    asked = ask(
        model,
        flights,
        reference,
        save_model=save_model,
        effects_from=effects_from,
        start=start,
        stop=stop,
        command_steps=command_steps,
        accept=accept,
        skip_rejected=skip_rejected,
    )
    used = asked.flights.flights
    _say(quiet, f"diagnosing {len(used)} flights, {sum(len(f.t) for f in used)} rows")
    found = asked.answer(matters=matters, seed=seed)
    saved = save_model if save_model is not None and asked.save(found, save_model) else None
    _say(quiet, "computing where it fails, and the error of every combination of effects")
    words = ["infotraj", "report", *sys.argv[2:]] if sys.argv[1:2] == ["report"] else ["infotraj", "report"]
    content = gathered(asked, found, seed=seed, matters=matters, saved=saved, command=words)
    if json_file is not None:
        files.write_json(content, json_file)
    _write(content, output, quiet)
    click.echo(sentence(found))
    files.say_unmet(accept, asked.flights.codes + [d.code for d in found.doubts])


def _require_one(
    model: Path | None, flights: tuple[Path, ...], from_json: Path | None, with_flights: tuple[object, ...]
) -> None:
    """UsageError unless there is either a model with flights or a content to draw."""
    if from_json is None and (model is None or not flights):
        raise UsageError(problem("no MODEL with FLIGHTs", "both, or --from-json FILE", "Name them."))
    if from_json is not None and (model is not None or any(with_flights)):
        found = "--from-json with a model, or with an option of a diagnosis"
        raise UsageError(problem(found, "one of them", "Leave one out: from a file nothing is computed."))


def _write(content: dict, output: Path, quiet: bool) -> None:
    from infotraj.report.page import write_page

    write_page(content, output)
    _say(quiet, f"{output}: {output.stat().st_size / 1e6:.1f} MB, opens in any browser")


def _say(quiet: bool, line: str) -> None:
    if not quiet:
        click.echo(line, err=True)
