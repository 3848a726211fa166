"""Files that a configuration names: one that is not there is refused in one line, with the names that are."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from infotraj.errors import UsageError
from infotraj.experiment.common.config import load
from infotraj.experiment.common.named_files import with_its_files

TOP = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def project(tmp_path, monkeypatch):
    for name in ("vehicles", "plants", "closed_loop"):
        shutil.copytree(TOP / "config" / name, tmp_path / "config" / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_defaults_are_there():
    with_its_files(load({}))


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"plants": ["omav_a", "omav_z"]}, "plants: omav_z is not in config/plants; expected one of omav_a, omav_b"),
        ({"plants": ["omav_A"]}, "Did you mean omav_a?"),
        ({"vehicle": "config/vehicles/omv.yaml"}, "vehicle: config/vehicles/omv.yaml is not in .* Did you mean .*omav"),
        ({"vehicle": "elsewhere/mine.yaml"}, "elsewhere; expected files there, and there are none"),
        ({"closed_loop": {"cases": ["x"], "shown": "x"}}, "closed_loop.cases: x is not in .*; expected one of com_off"),
    ],
)
def test_one_that_is_not_there_is_refused_in_one_line(content, says):
    with pytest.raises(UsageError, match=says) as caught:
        with_its_files(load(content))
    assert "\n" not in str(caught.value)


def test_a_case_of_the_loop_needs_both_of_its_files(project):
    (project / "config/closed_loop/com_offset/oracle.yaml").unlink()
    with pytest.raises(UsageError, match=r"closed_loop\.cases: com_offset is not in"):
        with_its_files(load({}))


def test_a_vehicle_of_your_own_needs_no_plants(project):
    shutil.rmtree(project / "config/plants")
    with_its_files(load({"execution": "log"}))
    with pytest.raises(UsageError, match="plants: omav_a is not in"):
        with_its_files(load({}))
