"""The model as given and as diagnosed on flights that were not fitted."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.diagnosis import score_held_out

with job(snakemake.log[0], snakemake.params.settings) as settings:
    name, flights, model = snakemake.wildcards.dataset, snakemake.input.flights, snakemake.input.model
    score_held_out(settings, name=name, config="config", flights=flights, model=model, table=snakemake.output.table)
