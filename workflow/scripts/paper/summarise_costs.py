"""What each cost's choice was worth, over all runs."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.costs_summary import summarise

with job(snakemake.log[0]):
    inputs, outputs = snakemake.input, snakemake.output
    summarise(hindsight=inputs.hindsight, costs=inputs.costs, table=outputs.table, markdown=outputs.markdown)
