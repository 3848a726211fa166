"""Diagnoses the flights of one batch with the public command; nothing here knows what is hidden."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.diagnosing import diagnose_batch

with job(snakemake.log[0]):
    diagnose_batch(flights=Path(snakemake.input.flights), answers=Path(snakemake.output.answers))
