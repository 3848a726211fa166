"""The claims."""

from infotraj.experiment.claiming import write_claims
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    tracking, correlation = snakemake.input.tracking, snakemake.input.correlation
    pool = snakemake.input.pool if snakemake.input.pool else None
    outputs = dict(snakemake.output.items())
    write_claims(tracking=tracking, correlation=correlation, pool=pool, points=snakemake.params.points, **outputs)
