"""The logs of a public data set that are diagnosed, cut to their windows."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.windows import cut_flights

with job(snakemake.log[0], snakemake.params.settings) as settings:
    cut_flights(
        settings, name=snakemake.wildcards.dataset, data_dir=settings.data_dir, flights=snakemake.output.flights
    )
