"""The prior model of a run."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.models import learn_prior

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    learn_prior(settings, plant, seed, flight=snakemake.input.flight, model=snakemake.output.model)
