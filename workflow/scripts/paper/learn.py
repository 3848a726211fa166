"""The models of a round from the flight of one source."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.models import learn_round

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed, source = snakemake.wildcards.plant, int(snakemake.wildcards.seed), snakemake.wildcards.source
    models = dict(zip(settings.added_points, snakemake.output.models, strict=True))
    flight, start = snakemake.input.flight, snakemake.input.start
    learn_round(settings, plant, seed, source, start=start, flight=flight, models=models)
