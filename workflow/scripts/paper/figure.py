"""One figure: the rule's named inputs and outputs are the function's arguments."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper import figures

with job(snakemake.log[0]):
    draw = getattr(figures, snakemake.params.function)
    draw(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
