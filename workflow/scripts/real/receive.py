"""The logs of a public data set: checked, and the usable ones as flight tables."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.flights import receive_logs

with job(snakemake.log[0], snakemake.params.settings) as settings:
    receive_logs(name=snakemake.wildcards.dataset, data_dir=settings.data_dir, **dict(snakemake.output.items()))
