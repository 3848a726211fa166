"""Diagnoses the flights of one batch with the public command; nothing here knows what changed."""

from pathlib import Path

from infotraj.experiment.changes.answering import answer_changes
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    answer_changes(flights=Path(snakemake.input.flights), answers=Path(snakemake.output.answers))
