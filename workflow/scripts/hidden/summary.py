"""Tables and figures of the hidden-effect study."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.summary import summarise

with job(snakemake.log[0], snakemake.params.settings) as settings:
    out = snakemake.output
    scores = [Path(p) for p in snakemake.input.scores]
    summarise(settings.hidden_effects, scores, Path(out.markdown), Path(out.tables), Path(out.figures))
