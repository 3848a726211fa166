"""Named effects added to a public data set's model."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.diagnosis import add_named

with job(snakemake.log[0], snakemake.params.settings) as settings:
    name, flights = snakemake.wildcards.dataset, snakemake.input.flights
    add_named(settings, name=name, config="config", flights=flights, **dict(snakemake.output.items()))
