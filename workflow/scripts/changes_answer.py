"""Diagnoses the flights of one batch with the public command; nothing here knows what changed."""

from pathlib import Path

from infotraj.experiment.change_answering import answer_changes
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    answer_changes(flights=Path(snakemake.input.flights), answers=Path(snakemake.output.answers))
