"""By how much a number differs from the healthy one: a factor or a difference, with the error of that."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.diagnosis.judge.unexplained import Unexplained
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.diagnosis.linear.change import Change, changes
from infotraj.diagnosis.report.summary import sentence
from infotraj.effects import catalogue
from infotraj.report.formats import changes as lines
from infotraj.report.formats import numbers
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml")
EFFECTS = catalogue()


def candidate(name, **fixed):
    cls = EFFECTS[name]
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), tuple(fixed.items()))


def change(c, now, healthy, errors, known=None):
    at = places(c, VEHICLE)
    told = [True] * len(at) if known is None else known
    return changes(c, c.at(now), c.at(healthy), errors, told, at, VEHICLE)


def test_a_factor_changes_by_a_factor_whose_error_is_as_much_smaller_as_the_healthy_one_is_larger():
    rotor = candidate("rotor_effectiveness", rotor=2)
    (told,) = change(rotor, {"factor": 0.9155}, {"factor": 1.077}, {"factor": 0.001523})
    assert (told.name, told.times, told.unit) == ("factor", True, "")
    assert (told.value, told.standard_error) == (pytest.approx(0.85005, abs=1e-5), pytest.approx(0.001414, abs=1e-6))


def test_what_adds_to_a_positive_number_of_the_file_changes_that_number_by_a_factor():
    mass = VEHICLE.mass
    (told,) = change(candidate("mass_offset"), {"dm": 0.32 * mass}, {"dm": 0.1 * mass}, {"dm": 0.022 * mass})
    assert (told.name, told.times) == ("mass", True)
    assert (told.value, told.standard_error) == (pytest.approx(1.2), pytest.approx(0.02))
    inertia = candidate("inertia_error")
    named = change(inertia, dict.fromkeys(("dxx", "dyy", "dzz"), 0.0), dict.fromkeys(("dxx", "dyy", "dzz"), 0.0),
                   dict.fromkeys(("dxx", "dyy", "dzz"), 1e-5))  # fmt: skip
    assert [c.name for c in named] == ["inertia.xx", "inertia.yy", "inertia.zz"]


def test_other_numbers_change_by_a_difference_and_what_healthy_flights_do_not_show_by_none():
    centre = candidate("com_offset")
    now, healthy, errors = {"r": [0.006, -0.004, 0.5]}, {"r": [0.001, 0.0, 0.0]}, {"r": [1e-4, 2e-4, 0.1]}
    (told,) = change(centre, now, healthy, errors, [True, True, False])
    assert (told.name, told.times, told.unit) == ("r", False, "m")
    np.testing.assert_allclose(told.value[:2], [0.005, -0.004])
    assert told.value[2] is told.standard_error[2] is None
    assert change(centre, now, healthy, errors, [False] * 3) == ()


def test_the_sentence_and_the_page_say_the_change_with_its_own_error():
    names = ("rotor_effectiveness", "com_offset")
    own = ({"rotor": 2, "factor": 0.9155}, {"r": [0.006, 0.0, 0.0]})
    errors = ({"factor": 0.0015}, {"r": [1e-4, 1e-4, 1e-4]})
    findings = [Finding(n, "Supported", (n,), None, v, e) for n, v, e in zip(names, own, errors, strict=True)]
    told = {
        names[0]: (Change("factor", True, 0.85005, 0.001414),),
        names[1]: (Change("r", False, [0.005, 0.0, None], [1e-4, 2e-4, None], "m"),),
    }
    found = SimpleNamespace(
        supported=names, findings=findings, finding=lambda n: findings[names.index(n)], healthy=object(),
        changes=lambda f: told[f.name], judged=True, refused={}, file=(), unexplained=Unexplained(False, ()),
        beside=(), usual=np.ones(6), of_day=np.ones(6), as_ever=frozenset(),
        after=SimpleNamespace(rmse=np.ones(6), floor=np.ones(6)),
    )  # fmt: skip
    assert sentence(found) == (
        "Changed: rotor_effectiveness (rotor 2: factor 0.85 +- 0.0014 times the healthy one), "
        "com_offset (r by [0.005, 0, ?] +- [0.0001, 0.0002, ?] m)."
    )
    row = {
        "parameters": own[0], "standard_errors": errors[0], "change": [c.as_dict() for c in told[names[0]]],
        "reference": {"parameters": {"factor": 1.077}, "standard_errors": {"factor": 0.052}},
    }  # fmt: skip
    assert lines(row) == ["factor 0.8500 ± 0.0014 times the healthy one"]
    # The error of the change is no error of the number now.
    assert numbers(row, {"index": ["rotor"]}) == ["rotor 2 (counted from 0)", "factor 0.9155"]
    assert numbers(row, {}, "reference") == ["factor 1.077 ± 0.052"]
    assert lines({"change": [c.as_dict() for c in told[names[1]]]}) == [
        "r by (0.00500 ± 0.00010, 0.00000 ± 0.00020, –) m"
    ]
