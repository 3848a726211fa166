"""What each model of a run leaves of a flight that none has learned."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.evaluating import prediction_table

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    models = {"none": None, **dict(zip(snakemake.params.model_names, snakemake.input.models, strict=True))}
    prediction_table(settings, plant, seed, flight=snakemake.input.flight, models=models, table=snakemake.output.table)
