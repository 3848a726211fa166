"""Every flight of one group of logs against the healthy ones."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.what_changed import answer_group

with job(snakemake.log[0], snakemake.params.settings) as settings:
    answer_group(snakemake.input.study, snakemake.wildcards.group, settings.data_dir, snakemake.output.answers)
