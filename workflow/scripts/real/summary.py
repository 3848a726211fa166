"""One table over the public data sets and their models."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.flights import summarise

with job(snakemake.log[0]):
    summarise(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
