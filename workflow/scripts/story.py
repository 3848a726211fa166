"""The story's figure."""

from infotraj.experiment.job import job
from infotraj.experiment.story import story

with job(snakemake.log[0], snakemake.params.settings) as settings:
    story(settings, **dict(snakemake.input.items()), **dict(snakemake.output.items()))
