"""The plant flown again with every controller."""

from pathlib import Path

from infotraj.experiment.closed_loop.stages import fly_again
from infotraj.experiment.common.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    names = ("truth", "oracle", "test", "right", "wrong")
    read = {name: Path(snakemake.input[name]) for name in names}
    flights, table = [Path(path) for path in snakemake.input.flights], Path(snakemake.output.table)
    case, seed = snakemake.wildcards.case, int(snakemake.wildcards.seed)
    fly_again(settings, case, seed, flights=flights, table=table, **read)
