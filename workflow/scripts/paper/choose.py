"""The reference of a round, chosen by our cost or by the paper's."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.choosing import choose

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, source = snakemake.wildcards.plant, snakemake.wildcards.source
    seed, number = int(snakemake.wildcards.seed), int(snakemake.wildcards.round)
    inputs = {"task": snakemake.input.task, "model": snakemake.input.model}
    choose(settings, plant, seed, number, source, **inputs, **dict(snakemake.output.items()))
