"""Names what a batch hides, by the public command and in the ways of today; nothing here knows what is hidden."""

from pathlib import Path

from infotraj.experiment.hidden_diagnosing import diagnose_batch, name_batch
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    flights, answers = Path(snakemake.input.flights), Path(snakemake.output.answers)
    diagnose_batch(flights=flights, answers=answers)
    name_batch(flights=flights, answers=answers)
