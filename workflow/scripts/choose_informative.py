"""The informative reference of a round."""

from infotraj.experiment.choosing import choose_informative
from infotraj.experiment.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    run = snakemake.wildcards.plant, int(snakemake.wildcards.seed), int(snakemake.wildcards.round)
    task, model = snakemake.input.task, snakemake.input.model
    reference, costs, region = snakemake.output.reference, snakemake.output.costs, snakemake.output.region
    choose_informative(settings, *run, task=task, model=model, reference=reference, costs=costs, region=region)
