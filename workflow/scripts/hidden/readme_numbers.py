"""The README's numbers to trust, from published results."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.trusted import trusted, write_numbers

with job(snakemake.log[0]):
    text = trusted([Path(p) for p in snakemake.input.runs], Path(snakemake.input.changed))
    write_numbers(Path("README.md"), text)
