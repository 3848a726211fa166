"""`infotraj report`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from infotraj.errors import UsageError, problem
from infotraj.options import (
    PATH,
    Reading,
    effects_from_option,
    matters_option,
    quiet_option,
    reading_options,
    reference_option,
    save_model_option,
    say,
    seconds_option,
    seed_option,
)
from infotraj.progress import waiting
from infotraj.terminal import counted, show


@click.command("report")
@click.argument("model", required=False, type=PATH)
@click.argument("flights", nargs=-1, type=PATH, metavar="FLIGHT...")
@reference_option(": what differs from them is asked, not what the model lacks.")
@click.option("-o", "--output", required=True, type=PATH, help="The page (HTML).")
@click.option("--json", "json_file", type=PATH, help="All that the page shows, for programs.")
@click.option("--from-json", type=PATH, help="Draw the page from what --json wrote; nothing is computed.")
@click.option(
    "--design", type=PATH, help="The next flight, as `infotraj design --json` wrote it: shown with the next steps."
)
@save_model_option
@matters_option
@effects_from_option
@seconds_option
@reading_options()
@seed_option("Of the resamples and surrogates.")
@quiet_option
def report_command(
    model: Path | None,
    flights: tuple[Path, ...],
    reference: tuple[Path, ...],
    output: Path,
    json_file: Path | None,
    from_json: Path | None,
    design: Path | None,
    save_model: Path | None,
    matters: float,
    effects_from: tuple[Path, ...],
    seconds: float,
    reading: Reading,
    seed: int,
    quiet: bool,
) -> None:
    """Diagnose MODEL on FLIGHTs as `diagnose` does, and show all of it on one HTML page that needs no network.

    \b
    infotraj report vehicle.yaml flight_*.parquet -o report.html
    infotraj report --from-json report.json --design design.json -o report.html
    """
    _require_one(model, flights, from_json, (reference, json_file, save_model))
    from infotraj.comparing.outputs import try_outputs
    from infotraj.report.designed import read_design

    try_outputs(
        {"-o": output, "--json": json_file, "--save-model": save_model},
        {},
        models=[] if model is None else [model],
        flights=flights,
        reference=reference,
        effects_from=effects_from,
        contents=[p for p in (from_json, design) if p is not None],
    )
    following = read_design(design) if design is not None else None
    if from_json is not None:
        from infotraj.report.again import read_content

        _write(_with_design(read_content(from_json), following), output, quiet)
        return
    assert model is not None
    if following is not None:
        from infotraj.digest import sha256
        from infotraj.report.designed import require_made_for

        require_made_for(following, str(model), sha256(model) if model.is_file() else None)
    from infotraj.comparing import files
    from infotraj.diagnosis.report.asking import ask
    from infotraj.diagnosis.report.following import lines
    from infotraj.diagnosis.report.summary import sentence
    from infotraj.report.content import gathered

    say(quiet, "reading and checking the flights")
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
    say(quiet, f"diagnosing {counted(len(used), 'flight')}, {sum(len(f.t) for f in used)} rows")
    with waiting("diagnosing"):
        found = asked.answer(matters=matters, seed=seed)
    show(sentence(found))
    saved = save_model if save_model is not None and asked.save(found, save_model) else None
    say(quiet, "computing where it fails, and the error of every combination of effects")
    words = ["infotraj", "report", *sys.argv[2:]] if sys.argv[1:2] == ["report"] else ["infotraj", "report"]
    with waiting("searching where it fails"):
        content = gathered(asked, found, seed=seed, matters=matters, saved=saved, command=words)
    content = _with_design(content, following)
    if json_file is not None:
        files.write_json(content, json_file)
    _write(content, output, quiet)
    files.say_unmet(reading.accept, asked.flights.codes + [d.code for d in found.doubts])
    for line in lines(found, model, saved):
        click.echo(line, err=True)


def _with_design(content: dict[str, Any], design: dict[str, Any] | None) -> dict[str, Any]:
    """The content with the next flight, where there is one."""
    from infotraj.report.designed import beside, require_made_for

    if design is None:
        return content
    page = content["provenance"]
    require_made_for(design, page["model"], page["model_sha256"])
    return content | {"design": beside(design, content["flights"])}


def _require_one(
    model: Path | None, flights: tuple[Path, ...], from_json: Path | None, with_flights: tuple[object, ...]
) -> None:
    """UsageError unless there is either a model with flights or a content to draw."""
    if from_json is None and (model is None or not flights):
        raise UsageError(problem("no MODEL with FLIGHTs", "both, or --from-json FILE", "Name them."))
    if from_json is not None and (model is not None or any(with_flights)):
        found = "--from-json with a model, or with an option of a diagnosis"
        raise UsageError(problem(found, "one of them", "Leave one out: from a file nothing is computed."))


def _write(content: dict[str, Any], output: Path, quiet: bool) -> None:
    from infotraj.report.page import write_page

    write_page(content, output)
    say(quiet, f"{output}: {output.stat().st_size / 1e6:.1f} MB, opens in any browser")
