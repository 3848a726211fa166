"""What each cost's choice was worth, over all runs."""

from infotraj.experiment.costs_summary import summarise
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    inputs, outputs = snakemake.input, snakemake.output
    summarise(hindsight=inputs.hindsight, costs=inputs.costs, table=outputs.table, markdown=outputs.markdown)
