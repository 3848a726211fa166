"""Tables and figures of the hidden-effect study from the scores that are there."""

from pathlib import Path

from infotraj.experiment.common.job import job
from infotraj.experiment.hidden.summary import summarise

with job(snakemake.log[0], snakemake.params.settings) as settings:
    scores = [path for path in map(Path, snakemake.params.scores) if path.is_file()]
    made = Path(snakemake.params.folder)
    summarise(settings.hidden_effects, scores, made / "summary.md", made / "tables", made / "figures")
