"""The lines around an answer: what comes next, why a saved model has other numbers, what is one finding."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.diagnosis.judge.numbers import FileNumber
from infotraj.diagnosis.report.following import OTHERS, flight_command, lines, weighing, written_otherwise
from infotraj.diagnosis.report.reasons import about_takes
from infotraj.diagnosis.report.summary import sentence
from infotraj.diagnosis.report.vehicle_file import by_ratio
from infotraj.report.again import read_content
from infotraj.report.page import page

OVER_MASS = "thrust of all rotors over mass, factor"
MODEL, SAVED = Path("a.yaml"), Path("new.yaml")


def diagnosis(told, written, instances=()):
    """A diagnosis that names a drag with numbers `told`, and whose model has `written`."""
    finding = SimpleNamespace(
        name="linear_drag", verdict="Supported", group=("linear_drag",), parameters=told, instances=instances
    )
    effects = [SimpleNamespace(name="linear_drag", values=w) for w in written]
    flight = SimpleNamespace(meta={"source": "f.parquet"})
    return SimpleNamespace(
        findings=(finding,), model=SimpleNamespace(effects=effects), supported=("linear_drag",), beside=(),
        healthy=None, command_steps=1, by_velocity=False, judged=True, samples=[SimpleNamespace(flight=flight)],
        before=SimpleNamespace(rows=np.ones(6)),
    )  # fmt: skip


def test_a_saved_model_with_other_numbers_says_why_in_one_line():
    same, other = (diagnosis({"d": [0.1, 0.2, 0.0]}, [{"d": [x, 0.2, 0.0]}]) for x in (0.1, 0.11))
    assert written_otherwise(same) == []
    assert written_otherwise(other) == ["linear_drag"]
    assert lines(same, MODEL, SAVED)[0].startswith("next: ")
    first, following, *_ = lines(other, MODEL, SAVED)
    assert first.startswith("new.yaml has other numbers than the table for linear_drag: the table's are found")
    assert following.startswith("next: ")
    assert lines(other, MODEL, None)[0].startswith("next: ")


def test_each_rotor_of_a_saved_model_is_held_against_its_own_numbers():
    rotors = ({"rotor": 3, "factor": 0.8}, {"rotor": 1, "factor": 0.9})
    assert written_otherwise(diagnosis(rotors[0], rotors, rotors)) == []
    assert written_otherwise(diagnosis(rotors[0], [rotors[0], {"rotor": 1, "factor": 0.7}], rotors)) == ["linear_drag"]


def test_a_comparison_on_the_fitted_flights_says_that_others_are_the_test():
    found = diagnosis({"d": 0.1}, [{"d": 0.1}])
    assert lines(found, MODEL, SAVED) == ["next: infotraj compare new.yaml f.parquet --against a.yaml", OTHERS]
    assert OTHERS not in lines(found, MODEL, None)


@pytest.fixture(params=[OVER_MASS, "force over mass, factor"])
def file(request):
    names = ["inertia.xx", request.param, "rotor_0.thrust_coefficient", "mass"]
    return [FileNumber(name, 1.0, 1.1, 0.01, True) for name in names]


def test_thrust_over_mass_and_its_parts_are_one_finding(file):
    said = [(n.name, part) for n, part in by_ratio(file)]
    parts = [("rotor_0.thrust_coefficient", True), ("mass", True)]
    assert said == [(file[1].name, False), *parts, ("inertia.xx", False)]
    # A mass that is off by itself is a finding of its own.
    assert [part for _, part in by_ratio([file[0], file[3]])] == [False, False]
    # So is a rotor that is out of line where the ratio is not, whatever its input is told by.
    lone = replace(file[2], name="rotor_3.thrust, factor", ordinary=False)
    assert by_ratio([file[1], lone]) == [(file[1], False), (lone, False)]
    assert by_ratio([file[1], replace(lone, ordinary=True)])[1][1]
    assert by_ratio([replace(file[1], ordinary=False), lone])[1][1]


def test_the_page_puts_the_parts_of_the_ratio_under_it(file, quad_report):
    content = json.loads(json.dumps(read_content(quad_report / "report.json")))
    content["answer"]["file"] = [
        {"name": n.name, "declared": 1.0, "value": 1.1, "standard_error": 0.01, "ordinary": True, "of_ratio": part}
        for n, part in by_ratio(file)
    ]
    assert page(content).count("one finding with the ratio above") == 2


def test_the_page_says_why_numbers_of_the_file_are_in_doubt_and_which_load_is_told(quad_report):
    content = json.loads(json.dumps(read_content(quad_report / "report.json")))
    number = {"declared": 1.0, "value": 8.0, "standard_error": 0.1, "ordinary": False}
    doubted = [number | {"name": f"inertia.{a}", "doubt": "only 26 % goes with it"} for a in ("xx", "zz")]
    content["answer"] |= {"file": [*doubted, number | {"name": "mass", "doubt": None}], "load": None}
    assert page(content).count("in doubt<small>only 26 % goes with it</small>") == 2
    assert "a load of 0.1" not in page(content)
    content["answer"]["load"] = {"sentence": "mass and centre of mass together: a load of 0.1 kg"}
    assert page(content).count("together: a load of 0.1 kg.") == 1


def test_a_share_that_an_effect_takes_is_told_from_its_change(quad_report):
    reason = "it takes 0% of the error off flights that were not fitted"
    (line,) = about_takes([None, reason])
    assert "change is of" in line
    assert "takes is of" in line
    assert about_takes([None, "60 % probable"]) == []
    content = json.loads(json.dumps(read_content(quad_report / "report.json")))
    assert "Held-out change is of" not in page(content)
    row = next(r for r in content["answer"]["effects"] if r["name"] == "time_offset")
    row |= {"verdict": "Plausible", "reason": reason}
    assert page(content).count("Held-out change is of") == 1


def test_where_only_numbers_of_the_file_are_off_the_sentence_says_how_much_of_the_error_they_make():
    before, after = np.array([1.0, 1.0, 4.0, np.nan, 1.0, 1.0]), np.array([0.6, 0.2, 1.0, np.nan, 0.9, 0.01])
    found = SimpleNamespace(
        supported=(), beside=("mass_offset",), healthy=None, refused={"tz": "why"}, judged=True, file=(),
        before=SimpleNamespace(rmse=before), after=SimpleNamespace(rmse=after), by_file=1.0 - after / before,
        unexplained=SimpleNamespace(found=False, axes=()), faint={},
    )  # fmt: skip
    corrected = "the numbers of your vehicle file make most of the error: corrected, 75 to 80 % of it is gone on fy, fz"
    assert f"No missing effect is supported; nothing can be said about tz: why; {corrected}." == sentence(found)
    alone = SimpleNamespace(**{**vars(found), "refused": {"fy": "why", "tz": "why"}})
    assert sentence(alone).endswith("75 % of it is gone on fz.")
    assert sentence(SimpleNamespace(**{**vars(found), "refused": {}})).endswith("is gone on fy, fz, tz.")
    assert sentence(SimpleNamespace(**{**vars(found), "refused": {}, "faint": {"tz": 0.4}})).endswith(
        "is gone on fy, fz."
    )
    force, lag = (
        FileNumber(x, 0.0, v, 0.01, True, takes=t, label=x, on=("fy", "tx"))
        for x, v, t in (("a", 2.0, 0.6), ("b", 3.0, 0.9))
    )
    ratio = FileNumber(OVER_MASS, 1.0, 0.9, 0.01, True, takes=0.7, on=("fz",))
    more = [replace(force, name="c", takes=0.55), replace(force, name="d", label="not in the model", takes=0.99)]
    told = {"file": (force, ratio, lag, *more), "beside": ("mass_offset", "a", "b")}
    said = f", first of all b 3 and {OVER_MASS} 0.9 and a 2."
    assert sentence(SimpleNamespace(**{**vars(found), **told})).endswith(said)
    # A force along x takes nothing off fy and fz, of which the sentence says that most is gone.
    elsewhere = {"file": (replace(force, on=("fx",)), replace(lag, on=("fx", "tx")))}
    assert sentence(SimpleNamespace(**{**vars(found), **told, **elsewhere})).endswith("is gone on fy, fz.")
    doubted = {"file": (replace(force, doubt="why"), lag)}
    assert sentence(SimpleNamespace(**{**vars(found), **told, **doubted})).endswith(", first of all b 3.")
    for same in ({"beside": ()}, {"by_file": 0.0 * before}):
        assert "vehicle file" not in sentence(SimpleNamespace(**{**vars(found), **same}))


def test_a_mass_is_told_from_a_thrust_by_a_scale_and_everything_else_by_a_flight():
    found = diagnosis({"d": 0.1}, [{"d": 0.1}])

    def unsure(*group):
        return tuple(SimpleNamespace(name=n, verdict="Not separable", group=group, parameters={}) for n in group)

    found.findings = unsure("mass_offset", "thrust_scale")
    (told,) = [x for x in lines(found, MODEL, None) if x.startswith("what these flights cannot tell")]
    assert told.startswith("what these flights cannot tell: mass_offset from thrust_scale; no flight tells a mass")
    assert "weigh the vehicle" in told
    assert flight_command(found, MODEL) is None
    found.findings += unsure("actuation_delay", "rotor_lag")
    assert "--separate actuation_delay rotor_lag" in flight_command(found, MODEL)
    assert weighing(found) is not None
    # A weight says nothing of two that are both thrusts.
    found.findings = unsure("coaxial_loss", "thrust_scale")
    assert weighing(found) is None
    assert "--separate coaxial_loss thrust_scale" in flight_command(found, MODEL)
    found.findings = unsure("mass_offset", "inertia_error")
    assert weighing(found) is None
    assert "--separate mass_offset inertia_error" in lines(found, MODEL, None)[-1]


def test_the_page_has_a_step_that_no_command_takes(quad_report):
    content = json.loads(json.dumps(read_content(quad_report / "report.json")))
    before = page(content).count('class="copy"')
    content["next"].append({"why": "Weigh the vehicle", "command": ""})
    made = page(content)
    assert "<li><p>Weigh the vehicle.</p></li>" in made
    assert made.count('class="copy"') == before


def test_the_page_lists_every_rotor_that_is_named(quad_report):
    content = json.loads(json.dumps(read_content(quad_report / "report.json")))
    row = next(r for r in content["answer"]["effects"] if r["name"] == "rotor_effectiveness")
    rotors = [{"rotor": 1, "factor": 0.9}, {"rotor": 2, "factor": 0.8125}]
    row |= {"verdict": "Supported", "parameters": rotors[0], "standard_errors": {"factor": 0.01}, "instances": rotors}
    assert page(content).count("<small>and rotor 2, factor 0.8125</small>") == 1
