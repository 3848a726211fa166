"""Tables and figures of the hidden-effect study from the scores that are there."""

from pathlib import Path

from infotraj.experiment.hidden_summary import summarise
from infotraj.experiment.job import job

with job(snakemake.log[0], snakemake.params.settings) as settings:
    top = Path(snakemake.params.folder)
    scores = sorted(top.glob("wave*/*/scores.json"))
    made = top / "so_far"
    summarise(settings.hidden_effects, scores, made / "summary.md", made / "tables", made / "figures")
