"""What the diagnosis names on the flights, and wrong names fitted to them."""

from pathlib import Path

from infotraj.experiment.closed_loop.stages import name_effects
from infotraj.experiment.common.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    written = {name: Path(path) for name, path in snakemake.output.items()}
    flights = [Path(path) for path in snakemake.input.flights]
    name_effects(settings, snakemake.wildcards.case, flights=flights, **written)
