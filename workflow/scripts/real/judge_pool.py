"""Costs and errors of all recorded flights, one seed."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.pool import evaluate_pool

with job(snakemake.log[0], snakemake.params.settings) as settings:
    evaluate_pool(
        data_dir=settings.data_dir,
        table=snakemake.output.table,
        seeds=[int(snakemake.wildcards.seed)],
    )
