"""The batches of the hidden-effect study and the files that they make."""

from dataclasses import asdict

from infotraj.experiment.hidden.baselines import methods
from infotraj.experiment.hidden.cases import batches
from infotraj.experiment.hidden.config import read_study

HIDDEN_FOLDER = "results/hidden_effects"
HIDDEN_STUDY = checked(read_study, CONFIG.hidden_effects.study)
HIDDEN_BATCHES = {
    batch.key: batch
    for batch in checked(batches, HIDDEN_STUDY, CONFIG.hidden_effects.only, CONFIG.hidden_effects.seeds)
}
HIDDEN_WAVES = (1, 2, 3, 4)


def hidden_of(wave):
    """The folder of a wave's batches, with the batch's key as a wildcard: nothing in it tells what is hidden."""
    return f"{HIDDEN_FOLDER}/wave{wave}/{{key}}"


def hidden_scores(_=None):
    """The scores of all batches."""
    return [f"{HIDDEN_FOLDER}/wave{b.case.wave}/{key}/scores.json" for key, b in HIDDEN_BATCHES.items()]


def hidden_results(_=None):
    """What the study brings in the end."""
    return [f"{HIDDEN_FOLDER}/summary.md", f"{HIDDEN_FOLDER}/figures"]


def hidden_case(wildcards):
    """The case of a batch, as plain values."""
    return asdict(HIDDEN_BATCHES[wildcards.key].case)


def hidden_seeds(wildcards):
    """The seeds of a batch."""
    return list(HIDDEN_BATCHES[wildcards.key].seeds)


def hidden_study(wildcards):
    """What the study says that matters to a batch: an edit about one vehicle leaves the other's runs alone."""
    vehicle = HIDDEN_BATCHES[wildcards.key].case.vehicle
    plain = HIDDEN_STUDY.model_dump(mode="json", include={"base_seed", "vary", "clutter", "gusts", "vehicles"})
    return {**plain, "vehicles": {vehicle: plain["vehicles"][vehicle]}}
