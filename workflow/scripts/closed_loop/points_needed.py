"""The figure of the points that a Gaussian process needs."""

from infotraj.experiment.closed_loop.story import draw_points
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    draw_points(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
