"""Tracking errors of a run's validation flights."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.evaluating import tracking_table

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    flights = dict(zip(snakemake.params.flight_names, snakemake.input.flights, strict=True))
    tracking_table(settings, plant, seed, flights=flights, table=snakemake.output.table)
