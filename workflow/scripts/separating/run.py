"""Makes the runs of the study of separating flights that are not there yet."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.separating.cases import read_separating, runs
from infotraj.experiment.separating.scoring import score_runs

with job(snakemake.log[0]):
    for room, path in snakemake.params.studies.items():
        study, hidden = read_separating(path)
        score_runs(study, hidden, runs(study), Path(snakemake.params.scores[room]))
