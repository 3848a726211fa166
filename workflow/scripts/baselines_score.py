"""The score of users' ways against the truths."""

from infotraj.experiment.baselines_scoring import score
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    score(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
