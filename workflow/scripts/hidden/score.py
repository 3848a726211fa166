"""Scores the answers of one batch against the truth."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.scoring import score_batch

with job(snakemake.log[0]):
    given = {name: Path(snakemake.input[name]) for name in ("flights", "truth", "answers", "named")}
    score_batch(**given, scores=Path(snakemake.output.scores))
