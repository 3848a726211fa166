"""The page of the study of the iterated loop from the runs that are there."""

from infotraj.experiment.common.job import job
from infotraj.experiment.iterated.cases import read_iterated
from infotraj.experiment.iterated.table import summarise_iterated

with job(snakemake.log[0]):
    study, _ = read_iterated(snakemake.input.study)
    study = study.model_copy(update={"base_seed": int(snakemake.wildcards.seed)})
    summarise_iterated(snakemake.input.scores, study, snakemake.output.table, snakemake.output.markdown)
