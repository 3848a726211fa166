"""The models of a public data set against its flights."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.flights import compare_flights

with job(snakemake.log[0]):
    name, flights = snakemake.wildcards.dataset, snakemake.input.flights
    compare_flights(name=name, config="config", flights=flights, **dict(snakemake.output.items()))
