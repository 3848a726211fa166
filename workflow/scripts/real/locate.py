"""Where one model of a public data set fails."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.flights import locate_in_flights

with job(snakemake.log[0]):
    name, model, flights = snakemake.wildcards.dataset, snakemake.wildcards.model, snakemake.input.flights
    locate_in_flights(name=name, model=model, config="config", flights=flights, **dict(snakemake.output.items()))
