"""Cases of the table of real flights, cut from the public data sets; a test that needs one is skipped without them."""

import os
from pathlib import Path

import pytest

from infotraj.diagnosis.gates.observing import observe
from infotraj.experiment.real.answering import admit
from infotraj.experiment.real.cases import RealCase, cut_case, missing, read_cases
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.models.file import load_model

CONFIG = Path(__file__).parents[2] / "config"


def cut(name: str, folder: Path) -> tuple[RealCase, Model]:
    """The case, its flights cut into `folder`, and its model as given."""
    case = read_cases(CONFIG / "studies/real_table.yaml").get(name)
    absent = missing(case, Path(os.environ.get("INFOTRAJ_DATA", "data")))
    if absent:
        pytest.skip(absent)
    cut_case(case, folder)
    return case, load_model(CONFIG / case.model)


def used(case: RealCase, folder: Path, model: Model) -> list[Flight]:
    """The flights to fit that `check` and the diagnosis with this model let through."""
    return admit(case.fit, folder, model.vehicle, lambda flight: observe(model, [flight]))[0]
