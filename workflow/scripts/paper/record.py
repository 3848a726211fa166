"""The recordings of a run's flights."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.recordings import record

with job(snakemake.log[0], snakemake.params.settings) as settings:
    flights, models, recordings = snakemake.input.flights, snakemake.input.models, snakemake.output.recordings
    record(settings, flights=flights, models=models, recordings=recordings)
