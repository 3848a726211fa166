"""The page over all results."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.report.results_index import write_index

with job(snakemake.log[0]):
    shown = snakemake.params
    write_index(shown.entries, shown.recordings, snakemake.config, shown.points, Path(shown.page))
