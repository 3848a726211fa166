"""What choosing by the cost gained on recorded flights."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.pool import summarise_pool

with job(snakemake.log[0]):
    summarise_pool(
        table=snakemake.input.table,
        summary=snakemake.output.summary,
        markdown=snakemake.output.markdown,
    )
