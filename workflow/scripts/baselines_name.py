"""What users' ways name on one set of flights."""

from infotraj.experiment.baselines_scoring import name_flights
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    case, flights = snakemake.wildcards.case, snakemake.input.flights
    name_flights(vehicle=snakemake.input.vehicle, case=case, flights=flights, table=snakemake.output.table)
