"""The figure of the points that a Gaussian process needs."""

from infotraj.experiment.job import job
from infotraj.experiment.story import draw_points

with job(snakemake.log[0]):
    draw_points(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
