"""The page of the study of changes."""

from infotraj.experiment.changes.table import summarise_changes
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    out = snakemake.output
    summarise_changes(snakemake.input.scores, snakemake.params.planned, out.table, out.markdown)
