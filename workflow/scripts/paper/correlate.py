"""Costs and errors of one run's candidates around the pitching task."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.correlating import correlate

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    correlate(settings, plant, seed, reference=snakemake.input.reference, table=snakemake.output.table)
