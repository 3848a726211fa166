"""Flies the plants of one batch of the study of changes, before and after."""

from pathlib import Path

from infotraj.experiment.changes.cases import batches, read_changes
from infotraj.experiment.changes.flying import fly_changes
from infotraj.experiment.common.job import job

with job(snakemake.log[0]):
    study, hidden = read_changes(snakemake.input.study)
    batch, out = batches(study, hidden)[snakemake.wildcards.key], snakemake.output
    fly_changes(study, hidden, batch, flights=Path(out.flights), truth=Path(out.truth))
