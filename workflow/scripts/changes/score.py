"""Scores the answers of one batch of the study of changes."""

from pathlib import Path

from infotraj.experiment.changes.scoring import score_changes
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    given = {name: Path(snakemake.input[name]) for name in ("flights", "answers", "truth")}
    score_changes(**given, scores=Path(snakemake.output.scores))
