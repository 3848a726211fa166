"""Table I."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.figures import write_table_1

with job(snakemake.log[0]):
    outputs = dict(snakemake.output.items())
    write_table_1(table=snakemake.input.table, points=snakemake.params.points, **outputs)
