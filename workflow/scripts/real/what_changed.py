"""What was done to a vehicle against what was answered: table and figure."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.what_changed import write_what_changed

with job(snakemake.log[0], {}):
    out = snakemake.output
    write_what_changed(snakemake.input.study, snakemake.input.answers, out.table, out.markdown, out.pdf, out.png)
