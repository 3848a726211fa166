"""All cases of real flights side by side: what is known, what was answered, what cannot be."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.table import write_real_table

with job(snakemake.log[0], snakemake.params.settings) as settings:
    asked, outputs = settings.real_table, dict(snakemake.output.items())
    answers, where = snakemake.input.answers, settings.data_dir
    write_real_table(cases=asked.cases, only=asked.only, data_dir=where, answers=answers, **outputs)
