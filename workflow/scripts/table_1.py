"""Table I."""

from infotraj.experiment.figures import write_table_1
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    outputs = dict(snakemake.output.items())
    write_table_1(table=snakemake.input.table, points=snakemake.params.points, **outputs)
