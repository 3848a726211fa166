"""Diagnoses the flights of one batch with the public command; nothing here knows what is hidden."""

from pathlib import Path

from infotraj.experiment.hidden_diagnosing import diagnose_batch
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    diagnose_batch(flights=Path(snakemake.input.flights), answers=Path(snakemake.output.answers))
