"""The verdict on one effect from its evidence, by hand-made evidence, and which name stands for a group."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linear_fits import ROWS, VEHICLE, linear_fit

from infotraj.diagnosis.judge.evidence import Evidence
from infotraj.diagnosis.judge.needed import Judged
from infotraj.diagnosis.judge.unexplained import Structure, Unexplained
from infotraj.diagnosis.judge.verdicts import Finding, Judge, named
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.effects import effect_class
from infotraj.models import Model

SURE = {"probability": 0.99, "selected": 1.0, "rise": 1.0, "gain": 0.4, "falls": {"fx": 0.4}, "by_axis": {"fx": 1.0}}

AGAINST = {"heldout_change": 0.5, "flights_better": (0, 4), "selected": 0.0}


def judge(whole=None, left=(), order=(), search=None, refused=None, matters=0.05):
    structure = Unexplained(bool(left), tuple(left))
    return Judge(search, whole, (), tuple(order), structure, refused or {}, matters, np.random.default_rng(0))


def judged(name="linear_drag", **changed):
    cls = effect_class(name)
    candidate = Candidate(cls, tuple(p for p in cls.parameters if not p.index))
    values = {**SURE, **changed}
    fixed = {"heldout_change": -0.5, "ci95": (-0.6, -0.4), "flights_better": (4, 4), "axis": "fx"}
    return Judged(Member(candidate, candidate.absent(VEHICLE)), {}, Evidence(**{**fixed, **values}))


def left(axis, rise):
    return Structure(axis, 0.5, 0.0, rise, (), None, 0.0)


@pytest.mark.parametrize(
    ("changed", "verdict", "words"),
    [
        ({}, None, ""),
        ({"rise": 0.04}, "Not needed", "negligible"),
        ({"gain": 0.1}, "Plausible", "it takes 10% of the error off"),
        ({"gain": 0.0, **AGAINST}, "Not needed", "predicted worse with it, all of them"),
        ({"gain": 0.0, **AGAINST, "flights_better": (1, 4)}, "Plausible", "it takes 0% of the error off"),
        ({"gain": 0.0, **AGAINST, "selected": 0.01}, "Plausible", "it takes 0% of the error off"),
        ({"gain": 0.0, "selected": 0.0, "flights_better": (0, 4)}, "Plausible", "it takes 0% of the error off"),
        ({"probability": 0.9}, "Plausible", "90 % probable"),
        ({"selected": 0.9}, "Plausible", "better on 90 % of the resamples"),
    ],
)
def test_an_effect_is_named_where_it_matters_predicts_and_is_sure(changed, verdict, words):
    found, reason = judge()._doubt(judged(**changed))
    assert found == verdict
    assert words in reason


def test_a_clock_or_a_force_that_takes_half_of_an_error_is_named_as_soon_as_it_is_likely():
    """A clock is no worse for a wrong file; a constant force is there, be it the air's or the level's."""

    def doubt(name, healthy=None, **changed):
        search = SimpleNamespace(observation=SimpleNamespace(healthy=healthy))
        return judge(search=search)._doubt(judged(name, **changed))[0]

    assert doubt("time_offset", gain=0.8, probability=0.6) is None
    assert doubt("steady_force", gain=0.8, probability=0.6) is doubt("rotor_lag", gain=0.8, probability=0.6) is None
    # Held against healthy flights it is no matter of the file.
    assert doubt("rotor_lag", "some", gain=0.8, probability=0.6) == "Plausible"
    assert doubt("time_offset", gain=0.8, probability=0.4) == "Plausible"
    assert doubt("com_offset", gain=0.8, probability=0.6) == "Plausible"
    assert doubt("time_offset", gain=0.6, probability=0.6) == "Plausible"
    assert doubt("linear_drag", gain=0.8, probability=0.6) == "Plausible"


def test_what_may_be_part_of_a_larger_structure_on_its_axis_is_not_sure():
    """Over a plane, where the effect acts most; an error along z is none of it, and half of an error is enough."""

    def doubt(*rest, gain=0.4):
        falls = {"fx": 0.25, "fy": 0.15, "fz": 0.05}
        by_axis = {"fx": 1.0, "fy": 0.5, "fz": 9.0}
        return judge(left=rest)._doubt(judged(gain=gain, falls=falls, by_axis=by_axis))

    assert doubt(left("vx", 5.0)) == (None, "")
    verdict, reason = doubt(left("fx", 1.0), left("fy", 2.0))
    assert verdict == "Plausible"
    assert reason.startswith("on fy more is left")
    assert doubt(left("fx", 0.8), left("fy", 0.6)) == (None, "")
    assert doubt(left("fz", 5.0)) == (None, "")
    assert doubt(left("fx", 3.0), gain=0.7) == (None, "")


@pytest.mark.parametrize(
    ("times", "share", "named"), [(2.5, 0.4, False), (2.5, 0.6, True), (1.9, 0.1, True), (0.4, 0.1, False)]
)
def test_another_inertia_altogether_is_not_named_where_little_of_the_torque_goes_with_the_prediction(
    times, share, named
):
    """Beside a moment without a name that the rotors hold against, a larger inertia explains a part of it."""
    found = judged("inertia_error")
    more = (times - 1.0) * VEHICLE.inertia.yy
    member = replace(found.member, effect=effect_class("inertia_error")(dyy=more))
    observation = SimpleNamespace(vehicle=VEHICLE, model=lambda m: Model(VEHICLE, [x.effect for x in m]))
    made = judge(search=SimpleNamespace(observation=observation))
    faint = {"tx": 0.1, "tz": 0.1} | ({"ty": share} if share < 0.5 else {})
    verdict, reason = replace(made, faint=faint)._doubt(replace(found, member=member))
    assert (verdict is None) == named
    if not named:
        assert reason.startswith(f"the inertia about y would be {times:.2g} times the file's")
    assert made._doubt(replace(found, member=member)) == (None, "")


@pytest.mark.parametrize(
    ("name", "falls", "share", "named"),
    [
        ("thrust_scale", {"ty": 0.4, "tx": 0.1}, 0.4, False),
        ("thrust_scale", {"ty": 0.4, "tx": 0.1}, 0.6, True),
        ("thrust_scale", {"fz": 0.5, "ty": 0.4}, 0.4, True),
        ("moment_scale", {"ty": 0.4}, 0.4, False),
        ("inertia_error", {"ty": 0.4}, 0.4, False),
        ("angular_damping", {"ty": 0.4}, 0.4, False),
        ("angular_damping", {"ty": 0.4}, 0.6, True),
        ("com_offset", {"ty": 0.4}, 0.4, True),
    ],
)
def test_a_factor_of_the_torques_is_not_named_by_one_of_which_less_than_half_is_predicted(name, falls, share, named):
    """Noise in what is predicted makes its factor smaller as well; a force tells the thrust apart from that."""
    found = judged(name, falls=falls)
    observation = SimpleNamespace(vehicle=VEHICLE, model=lambda m: Model(VEHICLE, []))
    faint = {"tz": 0.1} | ({"ty": share} if share < 0.5 else {})
    made = replace(judge(search=SimpleNamespace(observation=observation)), faint=faint)
    verdict, reason = made._doubt(found)
    assert (verdict is None) == named
    if not named:
        assert reason.startswith("it shows most in the torque about y, of which only 40 % goes with the prediction")


def one_axis(sizes, chosen, names=("linear_drag", "quadratic_drag", "com_offset"), scale=1.0):
    def rows(rng, _):
        x = np.zeros((ROWS, 1 + len(names)))
        x[:, 1:] = scale * rng.standard_normal((ROWS, len(names)))
        x[:, 0] = x[:, 1:] @ sizes + rng.standard_normal(ROWS)
        return x

    search, whole = linear_fit(list(names), rows, list(chosen))
    search.known = tuple(m.candidate for m in whole.linear.point)
    return search, whole


def test_what_the_search_left_out_is_not_needed_and_why():
    search, whole = one_axis([1.0, 0.0, 0.3], ["linear_drag"])
    made = judge(whole, search=search)
    none, some = made._of_absent("quadratic_drag"), made._of_absent("com_offset")
    assert (none.verdict, none.reason) == ("Not needed", "it takes 0% of the error off flights that were not fitted")
    # A variance of 0.09 beside a noise of 1, 4 % of its root mean square: sure, and little.
    assert some.verdict == "Plausible"
    assert re.fullmatch("it takes [345]% of the error off flights that were not fitted", some.reason)
    assert made._of_absent("wind").reason == "in the model already"
    search.barred["com_offset"] = "it would end at a bound"
    assert made._of_absent("com_offset").reason == "it would end at a bound"


def test_what_flights_do_not_excite_or_what_acts_beside_others_alone_is_not_testable():
    search, whole = one_axis([0.0, 0.0, 0.0], [], scale=0.01)
    found = judge(whole, search=search, refused={"tx": "why"})._of_absent("linear_drag")
    assert found.verdict == "Not testable here"
    assert "do not excite it" in found.reason
    assert "(not tx: why)" in found.reason
    for chosen, verdict in (([], "Not testable here"), (["linear_drag"], "Not needed")):
        search, whole = one_axis([1.0, 0.0], chosen, ("linear_drag", "wind"))
        found = judge(whole, search=search)._of_absent("wind")
        assert found.verdict == verdict
        assert ("beside rotor_drag or linear_drag" in found.reason) == (not chosen)


def test_what_predicts_as_well_and_has_fewer_numbers_stands_for_a_group(monkeypatch):
    order = ("com_offset", "thrust_scale", "mass_offset", "wind")
    members = [(judged(n).member, {}, SimpleNamespace(fit=n)) for n in order]
    leaves = {"com_offset": 1.0, "thrust_scale": 1.04, "mass_offset": 1.2, "wind": 1.0}
    monkeypatch.setattr("infotraj.diagnosis.judge.verdicts.left_by_set", lambda fit: np.array([leaves[fit] - 0.3, 0.3]))
    made = judge(order=order, search=SimpleNamespace(observation=SimpleNamespace(vehicle=VEHICLE)))
    names = [m.candidate.name for m, *_ in made._simplest_first(members)]
    assert names == ["thrust_scale", "com_offset", "wind", "mass_offset"]


def test_names_are_those_of_supported_effects_and_of_the_first_of_each_group():
    def finding(name, verdict, *group):
        return Finding(name, verdict, group or (name,), None, {}, {})

    pair = ("b", "c")
    found = [finding("c", "Not separable", *pair), finding("a", "Supported"), finding("b", "Not separable", *pair)]
    assert named([*found, finding("d", "Plausible")]) == ("b", "a")


def test_a_sure_effect_that_raises_the_error_by_too_little_is_not_needed():
    search, whole = one_axis([1.0, 0.0, 0.3], ["linear_drag"])
    assert judge(whole, search=search, matters=100.0)._of_absent("com_offset").verdict == "Not needed"


def test_an_effect_is_judged_where_it_is_most_probable_and_by_its_strongest_column():
    """Two linearisations of one effect, of which the second fits; and one of two columns, of which one does nothing."""
    search, whole = one_axis([0.0, 0.0, 0.6], [])
    drag, first, second = whole.linear.choices
    both = replace(whole.linear, choices=(drag, first, replace(second, label="quadratic_drag")))
    found = judge(replace(whole, linear=both), search=search)._of_absent("quadratic_drag")
    assert found.evidence.gain == pytest.approx(0.5 * np.log(1.36), abs=0.03)
    search, whole = one_axis([0.0, 0.0, 0.0], [], scale=np.array([1.0, 1e-3, 1.0]))
    together = (drag, replace(first, columns=(1, 2)), second)
    whole = replace(whole, linear=replace(whole.linear, choices=together))
    assert judge(whole, search=search)._of_absent("quadratic_drag").verdict == "Not needed"


def test_of_several_rotors_of_one_name_all_are_told_the_one_that_takes_most_off_first(monkeypatch):
    cls = effect_class("rotor_effectiveness")

    def of(rotor, factor, gain, **evidence):
        candidate = Candidate(cls, tuple(p for p in cls.parameters if not p.index), (("rotor", rotor),))
        made = judged(gain=gain, **evidence)
        return Judged(Member(candidate, cls(rotor=rotor, factor=factor)), {}, made.evidence)

    many = (of(0, 0.9, 0.3), of(3, 0.7, 0.9), of(1, 0.99, 0.1))
    monkeypatch.setattr("infotraj.diagnosis.judge.verdicts.rivals", lambda *_: [])
    monkeypatch.setattr("infotraj.diagnosis.judge.verdicts.fitted_numbers", lambda _: [])
    search = SimpleNamespace(observation=SimpleNamespace(vehicle=VEHICLE))
    whole = SimpleNamespace(linear=SimpleNamespace(observation=search.observation), members=())
    monkeypatch.setattr("infotraj.diagnosis.judge.verdicts.left_by_set", lambda fit: np.zeros(6))
    order = ("rotor_effectiveness", "wind")
    made = replace(judge(whole, order=order, search=search), judged=many)
    (found, hidden), stand = made.findings({"wind": "no air"})
    assert found.parameters == {"rotor": 3, "factor": 0.7}
    assert [x["rotor"] for x in found.instances] == [3, 0]
    unsure = (*many[:2], of(2, 0.95, 0.4, probability=0.6))
    assert [x["rotor"] for x in replace(made, judged=unsure).findings({"wind": "no air"})[0][0].instances] == [3, 0]
    assert (hidden.verdict, hidden.reason) == ("Not testable here", "no air")
    assert stand == {}
    alone = replace(made, judged=many[:1]).findings({"wind": "no air"})[0][0]
    assert alone.instances == ()
