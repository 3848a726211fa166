"""Every candidate of a run flown, learned from and put into the loop."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.hindsight import hindsight

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    task, model = snakemake.input.task, snakemake.input.model
    hindsight(settings, plant, seed, task=task, model=model, table=snakemake.output.table)
