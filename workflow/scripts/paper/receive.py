"""One flight that you flew."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.receiving import receive

with job(snakemake.log[0], snakemake.params.settings) as settings:
    folder, name = Path(settings.flights) / f"seed{snakemake.wildcards.seed}", snakemake.wildcards.flight
    receive(folder=folder, name=name, reference=snakemake.input.reference, flight=snakemake.output.flight)
