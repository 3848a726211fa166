"""What a Gaussian process leaves of a held-out flight, with and without the named effects."""

from pathlib import Path

from infotraj.experiment.closed_loop.stages import points_needed
from infotraj.experiment.common.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    case, seed = snakemake.wildcards.case, int(snakemake.wildcards.seed)
    test, right, table = (Path(x) for x in (snakemake.input.test, snakemake.input.right, snakemake.output.table))
    flights = [Path(path) for path in snakemake.input.flights]
    points_needed(settings, case, seed, flights=flights, test=test, right=right, table=table)
