"""The page of the study of changes."""

from infotraj.experiment.change_table import summarise_changes
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    out = snakemake.output
    summarise_changes(snakemake.input.scores, snakemake.params.planned, out.table, out.markdown)
