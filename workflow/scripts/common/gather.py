"""Tables of single jobs below each other."""

from infotraj.experiment.common.job import job
from infotraj.experiment.common.tables import gather

with job(snakemake.log[0]):
    gather(tables=snakemake.input.tables, table=snakemake.output.table)
