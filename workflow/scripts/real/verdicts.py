"""The diagnoses of all public data sets side by side."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.verdicts import summarise_diagnoses

with job(snakemake.log[0]):
    summarise_diagnoses(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
