"""A rollout of the chosen reference."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.rollouts import simulate_chosen

with job(snakemake.log[0], snakemake.params.settings) as settings:
    run = snakemake.wildcards.plant, int(snakemake.wildcards.seed), int(snakemake.wildcards.round)
    reference, model = snakemake.input.reference, snakemake.input.model
    simulate_chosen(settings, *run, reference=reference, model=model, rollout=snakemake.output.rollout)
