"""The diagnosis of a public data set's model on its flights."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.diagnosis import diagnose_flights

with job(snakemake.log[0], snakemake.params.settings) as settings:
    name, flights = snakemake.wildcards.dataset, snakemake.input.flights
    diagnose_flights(settings, name=name, config="config", flights=flights, **dict(snakemake.output.items()))
