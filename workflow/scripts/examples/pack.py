"""The example flights: those that changed, the healthy ones, one as a flight controller's log, and the sealed truth."""

from infotraj.examples.packing import board_log, pack, seal
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    pack(snakemake.input.changed, snakemake.output.changed)
    pack(snakemake.input.healthy, snakemake.output.healthy)
    board_log(snakemake.output.changed[0], snakemake.output.log)
    seal(f"{snakemake.input.truth}/run.yaml", snakemake.output.truth)
