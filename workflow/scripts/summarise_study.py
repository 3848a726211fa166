"""The study's choices over all runs, as a table."""

from pathlib import Path

from infotraj.experiment.job import job
from infotraj.experiment.studying import summarise

with job(snakemake.log[0]):
    summarise(tables=[Path(path) for path in snakemake.input.tables], markdown=Path(snakemake.output.markdown))
