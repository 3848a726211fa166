"""The claims."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper.claiming import write_claims

with job(snakemake.log[0]):
    tracking, correlation = snakemake.input.tracking, snakemake.input.correlation
    pool = snakemake.input.pool if snakemake.input.pool else None
    outputs = dict(snakemake.output.items())
    write_claims(tracking=tracking, correlation=correlation, pool=pool, points=snakemake.params.points, **outputs)
