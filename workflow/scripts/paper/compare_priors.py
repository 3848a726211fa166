"""One run with and without the prior that knows physics."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.priors import compare_priors

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed, given = snakemake.wildcards.plant, int(snakemake.wildcards.seed), snakemake.input
    table = snakemake.output.table
    compare_priors(settings, plant, seed, task=given.task, modified=given.modified, flight=given.flight, table=table)
