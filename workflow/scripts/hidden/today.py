"""What today's ways name in the flights of one batch; nothing here knows what is hidden."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.today import name_batch

with job(snakemake.log[0]):
    name_batch(flights=Path(snakemake.input.flights), named=Path(snakemake.output.named))
