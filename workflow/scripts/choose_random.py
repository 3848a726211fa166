"""The reference of a round, drawn at random."""

from infotraj.experiment.choosing import choose_random
from infotraj.experiment.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    run = snakemake.wildcards.plant, int(snakemake.wildcards.seed), int(snakemake.wildcards.round)
    choose_random(settings, *run, task=snakemake.input.task, reference=snakemake.output.reference)
