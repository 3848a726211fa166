"""The ranks of Fig. 2 under other choices of region, draws and hyperparameters, for one run."""

from infotraj.experiment.job import job
from infotraj.experiment.studying import study

with job(snakemake.log[0], snakemake.params.settings) as settings:
    plant, seed = snakemake.wildcards.plant, int(snakemake.wildcards.seed)
    study(settings, plant, seed, reference=snakemake.input.reference, table=snakemake.output.table)
