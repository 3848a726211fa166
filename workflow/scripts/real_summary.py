"""One table over the public data sets and their models."""

from infotraj.experiment.job import job
from infotraj.experiment.real_flights import summarise

with job(snakemake.log[0]):
    summarise(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
