"""The page of the study of separating flights from the runs that are there."""

from infotraj.experiment.common.job import job
from infotraj.experiment.separating.cases import read_separating
from infotraj.experiment.separating.table import summarise_separating

with job(snakemake.log[0]):
    study, _ = read_separating(snakemake.input.study)
    study = study.model_copy(update={"base_seed": int(snakemake.wildcards.seed)})
    summarise_separating(snakemake.input.scores, study, snakemake.output.table, snakemake.output.markdown)
