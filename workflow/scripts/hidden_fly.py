"""Flies the plants of one batch of the hidden-effect study."""

from pathlib import Path

from infotraj.experiment.hidden_cases import Batch, Case
from infotraj.experiment.hidden_config import load_study
from infotraj.experiment.hidden_flying import fly_batch
from infotraj.experiment.job import job

with job(snakemake.log[0]):
    given = snakemake.params
    batch = Batch(Case(**given.case), tuple(given.seeds))
    out = snakemake.output
    fly_batch(load_study(given.study, "study"), batch, flights=Path(out.flights), truth=Path(out.truth))
