"""What the diagnosis answers to one case of real flights, and the error on flights that were not fitted."""

from infotraj.experiment.common.job import job
from infotraj.experiment.real.answering import answer_case

with job(snakemake.log[0]):
    asked = {"cases": snakemake.params.cases, "name": snakemake.wildcards.case}
    answer_case(**asked, config="config", flights=snakemake.input.flights, **dict(snakemake.output.items()))
