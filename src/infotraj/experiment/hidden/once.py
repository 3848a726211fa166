"""One run of the hidden-effect study, chosen word by word, flown to two folders: what is shown and what is hidden.

    python -m infotraj.experiment.hidden.once FOLDER TRUTH --vehicle omav --effects linear_drag,com_offset:0.5
        --other slosh --file 3% --log autopilot --clutter --seed 7

FOLDER gets vehicle.yaml and flight_0.parquet to flight_3.parquet, TRUTH everything else.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from infotraj.errors import UsageError, problem
from infotraj.experiment.hidden.cases import Case
from infotraj.experiment.hidden.config import HiddenStudy, read_study
from infotraj.experiment.hidden.file_profiles import LEVELS
from infotraj.experiment.hidden.flying import fly_run
from infotraj.experiment.hidden.logs import LOGS

KINDS = {0: "nothing", 1: "single", 2: "pair", 3: "triple"}


def chosen(study: HiddenStudy, vehicle: str, effects: str, other: str, **more: Any) -> Case:
    """The case of these names; an effect may end in `:size`, a multiple of its usual one. UsageError otherwise."""
    if vehicle not in study.vehicles:
        raise UsageError(problem(f"vehicle {vehicle!r}", " or ".join(study.vehicles), "Correct --vehicle."))
    settings = study.vehicles[vehicle]
    named = [part.partition(":") for part in effects.split(",") if part]
    beyond = [name for name in other.split(",") if name]
    known = {"--effects": {*settings.effects, *settings.cannot_show}, "--other": {*settings.richer, *settings.unlisted}}
    for option, names in (("--effects", [n for n, _, _ in named]), ("--other", beyond)):
        for name in names:
            if name not in known[option]:
                raise UsageError(problem(f"{option} {name}", ", ".join(sorted(known[option])), "Correct the name."))
    try:
        sized = tuple((name, float(size or 1.0)) for name, _, size in named)
    except ValueError as error:
        raise UsageError(problem(f"--effects {effects}", "numbers after the colons", "Correct them.")) from error
    kind = KINDS.get(len(sized), "several")
    if beyond:
        kind = "richer" if beyond[0] in settings.richer else "unlisted"
    volts = [settings.effects[n].voltage for n, _ in sized if n in settings.effects]
    volts += [settings.richer[n].voltage for n in beyond if n in settings.richer]
    case = Case(vehicle, kind, sized, tuple(beyond), voltage=next((v for v in volts if v), None))
    return replace(case, **more)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("truth", type=click.Path(path_type=Path))
@click.option("--study", default="config/studies/hidden_effects.yaml", help="What is hidden, and how large.")
@click.option("--vehicle", required=True, help="One of the study's.")
@click.option("--effects", default="", help="Of the catalogue: name or name:size, with commas.")
@click.option("--other", default="", help="Physics beyond the catalogue, with commas.")
@click.option("--file", default="exact", type=click.Choice(list(LEVELS)), help="How wrong the vehicle file is.")
@click.option("--log", default="clean", type=click.Choice(list(LOGS)), help="How the flights are logged.")
@click.option("--clutter", is_flag=True, help="A vehicle that differs a little from its file, in turbulence.")
@click.option("--gusts", is_flag=True, help="In Dryden's gusts.")
@click.option("--seconds", type=float, help="s, of each flight, instead of the study's.")
@click.option("--seed", default=0, help="Of paths, values, noise, file and log.")
def once(folder: Path, truth: Path, study: str, seed: int, **choice: Any) -> None:
    """Flies one run: what is shown goes to FOLDER, what is hidden to TRUTH."""
    whole = read_study(study)
    fly_run(whole, chosen(whole, **choice), seed, folder, truth)


if __name__ == "__main__":
    once()
