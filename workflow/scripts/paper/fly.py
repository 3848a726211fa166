"""One flight of the MuJoCo plant."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.flying import fly_reference

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed, flight = snakemake.wildcards.plant, int(snakemake.wildcards.seed), snakemake.wildcards.flight
    reference, model = snakemake.input.reference, snakemake.input.model or None
    fly_reference(settings, plant, seed, flight, reference=reference, model=model, flight=snakemake.output.flight)
