"""The reference of a round, drawn at random."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.choosing import choose_random

with job(snakemake.log[0], snakemake.params.settings) as settings:
    run = snakemake.wildcards.plant, int(snakemake.wildcards.seed), int(snakemake.wildcards.round)
    choose_random(settings, *run, task=snakemake.input.task, reference=snakemake.output.reference)
