"""Validation flights with the models of a round."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.evaluating import fly_with_models

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    references = {"task": snakemake.input.task, "modified": snakemake.input.modified}
    models = {"none": None, **dict(zip(snakemake.params.model_names, snakemake.input.models, strict=True))}
    flights = dict(zip(snakemake.params.flight_names, snakemake.output.flights, strict=True))
    fly_with_models(settings, plant, seed, references=references, models=models, flights=flights)
