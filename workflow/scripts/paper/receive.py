"""One flight that you flew."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.receiving import receive

with job(snakemake.log[0], snakemake.params.settings) as settings:
    receive(
        folder=Path(settings.flights) / f"seed{snakemake.wildcards.seed}",
        name=snakemake.wildcards.flight,
        reference=snakemake.input.reference,
        model=snakemake.input.model or None,
        flight=snakemake.output.flight,
    )
