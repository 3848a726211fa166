"""The task, the modified task and the pitching task."""

from infotraj.experiment.common.job import job
from infotraj.experiment.paper import references

with job(snakemake.log[0], snakemake.params.settings) as settings:
    references.write(
        settings,
        task=snakemake.output.task,
        modified=snakemake.output.modified,
        pitch=snakemake.output.pitch,
    )
