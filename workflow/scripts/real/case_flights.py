"""The logs of one case of real flights, imported and cut to their windows."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.cases import cut_case, read_cases

with job(snakemake.log[0], snakemake.params.settings) as settings:
    case = read_cases(snakemake.params.cases).get(snakemake.wildcards.case)
    cut_case(case, snakemake.output.flights, settings.data_dir)
