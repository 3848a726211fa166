"""The page of the study of changes from the scores that are there."""

from pathlib import Path

from infotraj.experiment.changes.table import summarise_changes
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    scores = [path for path in map(Path, snakemake.params.scores) if path.is_file()]
    made = Path(snakemake.params.folder)
    summarise_changes(scores, snakemake.params.planned, made / "table.csv", made / "table.md")
