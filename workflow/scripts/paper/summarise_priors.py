"""What the prior was worth, over all runs."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.priors_summary import summarise_priors

with job(snakemake.log[0]):
    outputs = snakemake.output
    summarise_priors(tables=snakemake.input.tables, table=outputs.table, markdown=outputs.markdown)
