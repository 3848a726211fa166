"""Flies the plants of one batch of the hidden-effect study."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.cases import Batch, Case
from infotraj.experiment.hidden.config import load_study
from infotraj.experiment.hidden.flying import fly_batch

with job(snakemake.log[0]):
    given = snakemake.params
    batch = Batch(Case(**given.case), tuple(given.seeds))
    out = snakemake.output
    fly_batch(load_study(given.study, "study"), batch, flights=Path(out.flights), truth=Path(out.truth))
