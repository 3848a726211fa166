"""The closed loop over all cases and seeds."""

from infotraj.experiment.closed_loop.summary import summarise
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    summarise(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
