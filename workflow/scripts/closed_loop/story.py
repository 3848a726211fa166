"""The story's figure."""

from infotraj.experiment.closed_loop.story import story
from infotraj.experiment.common.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    story(settings, **dict(snakemake.input.items()), **dict(snakemake.output.items()))
