"""The flights of a plant with a hidden effect, with the model as given."""

from pathlib import Path

from infotraj.experiment.closed_loop.stages import fly_nominal
from infotraj.experiment.common.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    case, seed, truth = snakemake.wildcards.case, int(snakemake.wildcards.seed), Path(snakemake.input.truth)
    flights, test = [Path(path) for path in snakemake.output.flights], Path(snakemake.output.test)
    fly_nominal(settings, case, seed, truth=truth, flights=flights, test=test)
