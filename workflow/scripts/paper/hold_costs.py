"""Many costs of one run's candidates."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.costs import hold_costs

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    task, model = snakemake.input.task, snakemake.input.model
    hold_costs(settings, plant, seed, task=task, model=model, table=snakemake.output.table)
