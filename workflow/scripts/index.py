"""The page over all results."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.report.results_index import write_index

with job(snakemake.log[0]):
    entries, recordings = snakemake.params.entries, list(snakemake.input.recordings)
    write_index(entries, recordings, snakemake.config, snakemake.params.points, Path(snakemake.output.page))
