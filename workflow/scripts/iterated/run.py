"""Makes the runs of the study of the iterated loop that are not there yet."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.iterated.cases import read_iterated, runs
from infotraj.experiment.iterated.scoring import score_runs

with job(snakemake.log[0]):
    study, hidden = read_iterated(snakemake.params.study)
    score_runs(study, hidden, runs(study), Path(snakemake.params.scores))
