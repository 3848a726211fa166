"""Numbers of effects and of the file in their own units: value, standard error, and when they are told."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.judge import numbers, ratio, verdicts
from infotraj.diagnosis.judge.evidence import Evidence
from infotraj.diagnosis.judge.giving import Given
from infotraj.diagnosis.judge.numbers import (
    by_parameter,
    file_numbers,
    fitted_numbers,
    labels_of_file,
    thrust_over_mass,
)
from infotraj.diagnosis.judge.unexplained import Structure, Unexplained
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.prior import Scales
from infotraj.effects import Effect, Parameter, effect_class
from infotraj.flight import Flight
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")


def candidate(name, **fixed):
    cls = effect_class(name)
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), tuple(fixed.items()))


def made_of(monkeypatch, thetas, deviation, spike=0.3, command_step=0.0, samples=(), **changed):
    """What a fit knows of one number of each candidate: theta, usual sizes, its deviation and what a file is off by."""
    columns = [
        SimpleNamespace(candidate=c, place=place, scale=places(c, VEHICLE)[place].scale) for c, place, _ in thetas
    ]
    observation = SimpleNamespace(vehicle=VEHICLE, healthy=None, command_step=command_step, samples=samples)
    linear = SimpleNamespace(columns=columns, observation=observation, spike=lambda _: np.full(len(columns), spike))
    linear.choices, linear.labelled = (), lambda labels: ()
    solution = SimpleNamespace(theta=np.array([x for *_, x in thetas]))
    monkeypatch.setattr(numbers, "overdispersion", lambda _: (1.0, deviation**2 * np.eye(len(columns))))
    monkeypatch.setattr(numbers, "told_errors", lambda *_: np.full(len(columns), deviation))
    monkeypatch.setattr(numbers, "variance_along", lambda _, weight: deviation**2 * weight @ weight)
    return SimpleNamespace(**{"linear": linear, "solution": solution, "scales": None, "labels": (), **changed})


def test_a_number_of_the_file_is_told_in_its_unit_with_its_error(monkeypatch):
    """Five usual sizes of a twentieth of the mass, as a logarithm; thrust of one rotor by its own coefficient; 4 ms."""
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {"fx": 0.6, "vz": 0.6, "tx": 0.4})
    asked = [
        (candidate("mass_offset"), 0, 5.0),
        (candidate("rotor_effectiveness", rotor=2), 0, -1.2),
        (candidate("rotor_lag"), 0, 0.2),
        (candidate("com_offset"), 1, 0.8),
        (candidate("steady_force"), 0, 0.2),
    ]
    mass, rotor, lag, center, force = file_numbers(made_of(monkeypatch, asked, 0.05), ())
    grown = VEHICLE.mass * np.exp(5.0 * 0.05)
    assert (mass.name, mass.declared, mass.unit) == ("mass", VEHICLE.mass, "kg")
    assert mass.value == pytest.approx(grown)
    assert mass.standard_error == pytest.approx(np.hypot(0.05 * 0.05 * grown, 0.0015 * VEHICLE.mass))
    k = VEHICLE.rotors[2].thrust_coefficient
    assert rotor.name == "rotor_2.thrust_coefficient"
    assert rotor.value == pytest.approx(k * np.exp(-1.2 * 0.15))
    assert rotor.standard_error == pytest.approx(0.05 * 0.15 * rotor.value)
    assert lag.value - lag.declared == pytest.approx(0.2 * 0.03)
    assert lag.standard_error == pytest.approx(0.05 * 0.03)
    scale = places(candidate("com_offset"), VEHICLE)[1].scale
    assert (center.name, center.value) == ("center_of_mass.y", pytest.approx(0.8 * scale))
    # Within three times what such a file is off by; half of an error is spoken of where nothing else does the same, or
    # would be as ordinary.
    assert [n.ordinary for n in (mass, rotor, lag, center, force)] == [False, False, True, True, True]
    assert [n.large for n in (mass, rotor, lag, center, force)] == [True, True, True, False, True]
    # A velocity against an accelerometer tells of the force along its axis; a centre of mass acts beside other numbers.
    assert [n.on for n in (lag, mass, center)] == [("fx", "fz"), ("fx", "fz"), ()]


def test_a_number_of_an_effect_that_is_not_named_says_why(monkeypatch):
    """That of the file alone, of which the set holds no effect, has no such reason."""
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})
    asked = [(candidate("inertia_error"), 2, 5.0), (candidate("com_offset"), 1, 0.8)]
    made = made_of(monkeypatch, asked, 0.05, labels=("inertia_error",))
    inertia, center = file_numbers(
        made, (), {"inertia_error": "it may stand for more", "com_offset": "0 % of the error"}
    )
    assert (inertia.name, inertia.doubt) == ("inertia.zz", "it may stand for more")
    assert center.doubt == ""
    assert [n.doubt for n in file_numbers(made, ())] == ["", ""]


@pytest.mark.parametrize(
    ("falls", "doubts"),
    [
        ({"ty": 0.2}, (True, True)),  # more is left across its axis than goes with it
        ({"ty": 0.8}, (False, True)),  # half of an error goes with it
        ({"fx": 0.2}, (False, False)),  # on that axis nothing is left
    ],
)
def test_a_number_may_be_part_of_what_is_left_beside_it(monkeypatch, falls, doubts):
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})
    made = made_of(monkeypatch, [(candidate("com_offset"), 0, 0.8), (candidate("rotor_lag"), 0, 0.2)], 0.05)
    of_each = [(falls, dict.fromkeys(falls, 1.0)), (dict.fromkeys(falls, 0.1), dict.fromkeys(falls, 0.2))]
    monkeypatch.setattr(numbers, "of_number", lambda _, i: of_each[i])
    left = Unexplained(True, (Structure("tx", 0.5, 0.1, 1.5, (), None, 0.0),))
    found = file_numbers(made, (), left=left)
    assert tuple(bool(n.doubt) for n in found) == doubts
    assert all(n.doubt.startswith("on tx more is left") for n in found if n.doubt)
    assert not any(n.doubt for n in file_numbers(made, ()))


def test_a_number_is_told_where_it_is_three_standard_errors_off(monkeypatch):
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    asked = [(candidate("mass_offset"), 0, 0.29), (candidate("com_offset"), 0, -0.31)]
    found = file_numbers(made_of(monkeypatch, asked, 0.1), ())
    assert [n.name for n in found] == ["center_of_mass.x"]


def test_numbers_of_an_effect_stand_by_parameter():
    class Both(Effect):
        """A vector and a number."""

        name, place = "both", "wrench"
        parameters = (Parameter("v", "N", 1.0, (-9.0, 9.0), size=3), Parameter("x", "N", 1.0, (-9.0, 9.0)))

    made = Member(Candidate(Both, Both.parameters), Both(v=[1.0, 2.0, 3.0], x=4.0))
    assert by_parameter(made, np.array([0.1, 0.2, 0.3, 0.4])) == {"v": [0.1, 0.2, 0.3], "x": 0.4}


def test_the_error_of_a_fitted_number_is_in_its_own_unit():
    """2000 rows of variance 1 beside noise of 1: a number to 1 / sqrt(2000) of its usual size, times its slope; a time
    no better than to a tenth of the 5 ms between commands, a mass no better than to the 0.15 % of gravity."""

    def rows(rng, _):
        x = rng.standard_normal((ROWS, 3))
        x[:, 0] += 2.0 * x[:, 1] + 4.0 * x[:, 2]
        return x

    _, whole = linear_fit(["actuation_delay", "mass_offset"], rows, ["actuation_delay", "mass_offset"])
    delay, mass = fitted_numbers(whole)
    assert delay["delay"] == pytest.approx(np.hypot(0.015 / np.sqrt(2000), 0.0005), rel=0.1)
    # The point has no mass added: there a step of the logarithm is one of the mass.
    told, pull = 0.05 * VEHICLE.mass / np.sqrt(2000), 0.0015 * VEHICLE.mass
    assert mass["dm"] == pytest.approx(np.hypot(told, pull), rel=0.15)
    heavier = whole.linear.point[1].candidate.at({"dm": VEHICLE.mass})
    moved = tuple(m if m.candidate.name != "mass_offset" else Member(m.candidate, heavier) for m in whole.members)
    whole.__dict__["members"] = moved
    # Twice as much a step, but gravity is as sure as it was.
    twice = 2.0 * np.sqrt(mass["dm"] ** 2 - pull**2)
    assert fitted_numbers(whole)[1]["dm"] == pytest.approx(np.hypot(twice, pull))


def test_clocks_and_mounts_and_what_does_not_act_are_no_file_to_correct():
    names = ["mass_offset", "time_offset", "com_offset", "linear_drag"]

    def rows(rng, _):
        x = rng.standard_normal((ROWS, 5))
        x[:, 3] = 0.0
        return x

    _, whole = linear_fit(names, rows, [])
    assert labels_of_file(whole) == ["mass_offset"]


def test_a_number_that_a_torque_tells_which_is_hardly_predicted_is_in_doubt(monkeypatch):
    """The first column is told by tx, the second by fz, of which a hover shows no change either. A centre of mass is
    told by what the torques are in the mean."""
    asked = [(candidate("rotor_effectiveness", rotor=k), 0, -1.2) for k in (2, 1)]
    made = made_of(monkeypatch, [*asked, (candidate("com_offset"), 1, 0.8)], 0.05)
    gram = np.zeros((2, 3, 4, 4))
    gram[0, :, 1, 1], gram[1, :, 1, 1], gram[1, :, 2, 2], gram[0, :, 3, 3] = 2.0, 1.0, 1.0, 1.0
    made.linear.sums = SimpleNamespace(axes=("tx", "fz"), gram=gram)
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})

    def doubts(faint):
        return [n.doubt for n in file_numbers(made, (), {}, faint)]

    assert doubts({"tx": 0.38}) == ["only 38 % of the torque about x goes with the prediction", "", ""]
    assert doubts({"ty": 0.1}) == doubts({}) == ["", "", ""]
    # Without torques about x and y no rotor is told from the others, whatever its arm has become.
    each = "only 38 % of the torque about x goes with the prediction"
    assert doubts({"tx": 0.38, "ty": 0.1}) == [each, each, ""]


def test_thrust_over_mass_has_the_doubt_of_the_thrust_that_is_not_named(monkeypatch):
    asked = [(candidate("thrust_scale"), 0, -1.0), (candidate("mass_offset"), 0, 0.5)]
    made = made_of(monkeypatch, asked, 0.04, labels=("thrust_scale",))
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {"fx": 0.6, "vz": 0.6, "tx": 0.4})
    monkeypatch.setattr(numbers, "off", lambda made, named: ())
    (ratio,) = file_numbers(made, (), {"thrust_scale": "why"})
    assert (ratio.name, ratio.doubt, ratio.large) == ("thrust of all rotors over mass, factor", "why", False)
    (ratio,) = file_numbers(made, (), {"mass_offset": "why"})
    assert (ratio.doubt, ratio.large) == ("", True)


def test_force_over_mass_is_the_ratio_of_a_vehicle_without_rotors(monkeypatch):
    made = made_of(monkeypatch, [(candidate("thrust_scale"), 0, -1.0)], 0.04, labels=("thrust_scale",))
    made.linear.observation.vehicle = VEHICLE.model_copy(update={"inputs": "wrench", "rotors": ()})
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})
    (told,) = thrust_over_mass(made, ())
    assert told.name == "force over mass, factor"
    assert told.ratio
    assert not replace(told, name="mass").ratio


@pytest.mark.parametrize("size", [1.8, 1.6])
def test_the_share_that_a_number_takes_is_of_the_root_mean_square(size):
    """A column of variance size^2 beside a noise of 1 makes the root mean square sqrt(1 + size^2) times larger."""

    def rows(rng, _):
        x = rng.standard_normal((ROWS, 3))
        x[:, 0] += size * x[:, 1] + 5.0 * x[:, 2]
        return x

    _, whole = linear_fit(["mass_offset", "linear_drag"], rows, ["mass_offset", "linear_drag"])
    share = 1.0 - 1.0 / np.hypot(1.0, size)
    assert numbers._takes(whole, np.array([1.0, 0.0]))["fx"] == pytest.approx(share, abs=0.03)
    # A direction has no length.
    assert numbers._takes(whole, np.array([0.1, 0.0]))["fx"] == pytest.approx(share, abs=0.03)
    # Of an axis that is hardly predicted a smaller prediction takes error as well.
    assert numbers._takes(whole, np.array([1.0, 0.0]), {"fx": 0.1}).get("fx") is None


def test_thrust_over_mass_is_told_with_the_error_of_a_factor(monkeypatch):
    rotors = [(candidate("rotor_effectiveness", rotor=i), 0, -0.8) for i in range(4)]
    made = made_of(monkeypatch, [*rotors, (candidate("mass_offset"), 0, 1.0)], 0.04)
    (found,) = thrust_over_mass(made, scales=Scales(1.0))
    factor = np.exp(-0.8 * 0.15 - 0.05)
    assert found.value == pytest.approx(factor)
    # A mean of four rotors' errors, that of the mass, and that of gravity.
    assert found.standard_error == pytest.approx(factor * np.linalg.norm([0.04 * 0.15 / 2.0, 0.04 * 0.05, 0.0015]))
    assert not found.ordinary
    assert thrust_over_mass(made_of(monkeypatch, [*rotors[:1]], 0.3), scales=Scales(1.0)) == []


def test_thrust_that_is_in_the_set_without_a_name_is_told_as_the_file_s(monkeypatch):
    """Else a fifth of the thrust would be told nowhere. A name says it once, and pairs' losses are no part of a sum."""
    asked = [(candidate("thrust_scale"), 0, -1.0), (candidate("mass_offset"), 0, 0.5)]
    made = made_of(monkeypatch, asked, 0.04, labels=("thrust_scale",))
    (found,) = thrust_over_mass(made, (), Scales(1.0))
    assert found.value == pytest.approx(np.exp(-1.0 * 0.1 - 0.5 * 0.05))
    assert thrust_over_mass(made, {"thrust_scale"}, Scales(1.0)) == thrust_over_mass(made, scales=Scales(1.0)) == []
    assert thrust_over_mass(made, {"mass_offset"}, Scales(1.0)) == []  # one of a group, which stands for the other
    lost = made_of(monkeypatch, asked, 0.04, labels=("coaxial_loss",))
    assert thrust_over_mass(lost, (), Scales(1.0)) == []


def evidence_of(**falls):
    return Evidence(-0.5, (-0.6, -0.4), (4, 4), 1.0, 1.0, "fz", falls=falls)


def with_ratio(monkeypatch, falls, out_of_line=True, beside=("thrust_scale", "com_offset")):
    """Findings where each label corrects thrust over mass with these falls; what is left beside the named ones."""
    monkeypatch.setattr(ratio, "evidence", lambda fit, label, rng: evidence_of(**falls[label]))
    monkeypatch.setattr(ratio, "out_of_line", lambda told, named: out_of_line)
    monkeypatch.setattr(numbers, "fitted_numbers", lambda fit, told: [{"factor": 0.1}])
    monkeypatch.setattr(verdicts, "values_of", lambda member: {"factor": 0.8})

    def fit(label):
        return SimpleNamespace(members=[SimpleNamespace(candidate=SimpleNamespace(label=label, name=label))])

    findings = tuple(Finding(x, "Not needed", (x,), None, {}, {}) for x in ("mass_offset", "thrust_scale", "wind"))
    made = Given(fit(""), {}, beside=beside, of_ratio={x: fit(x) for x in falls})
    found, given = ratio.with_ratio(findings, None, made, np.random.default_rng(0))
    return {f.name: f for f in found}, given.beside


def test_a_ratio_that_is_out_of_line_is_named_by_all_that_take_most_of_its_error(monkeypatch):
    falls = {"thrust_scale": {"fz": 1.2, "tx": 0.1}, "mass_offset": {"fz": 0.7}, "coaxial_loss": {"fz": 0.5}}
    found, beside = with_ratio(monkeypatch, falls)
    pair = ("thrust_scale", "mass_offset")
    assert [found[x].verdict for x in pair] == ["Not separable"] * 2
    assert found["thrust_scale"].group == found["mass_offset"].group == pair
    assert found["wind"].verdict == "Not needed"
    assert beside == ("com_offset",)
    alone, _ = with_ratio(monkeypatch, {"thrust_scale": {"fz": 1.2}})
    assert alone["thrust_scale"].verdict == "Supported"
    assert alone["thrust_scale"].standard_errors == {"factor": 0.1}


@pytest.mark.parametrize("changed", [{"falls": {"thrust_scale": {"fz": 0.6}}}, {"out_of_line": False}, {"beside": ()}])
def test_a_ratio_is_no_finding_where_it_is_in_line_or_takes_less_than_half_of_an_error(monkeypatch, changed):
    found, beside = with_ratio(monkeypatch, **{"falls": {"thrust_scale": {"fz": 1.2}}, **changed})
    assert {f.verdict for f in found.values()} == {"Not needed"}
    assert beside == changed.get("beside", ("thrust_scale", "com_offset"))


@pytest.mark.parametrize(("theta", "ordinary"), [(0.4, True), (0.6, False)])
def test_rotors_that_are_off_by_themselves_make_less_of_a_ratio_than_all_alike(monkeypatch, theta, ordinary):
    """A file's rotors differ by 0.3 usual sizes of 0.15 each, their mean by half of that: three of it are ordinary."""
    rotors = [(candidate("rotor_effectiveness", rotor=i), 0, theta) for i in range(4)]
    (found,) = thrust_over_mass(made_of(monkeypatch, rotors, 0.01), scales=Scales(1.0))
    assert (abs(theta) * 0.15 < 3.0 * 0.3 * 0.15 / 2.0) == ordinary == found.ordinary


def test_a_change_from_healthy_flights_is_as_unsure_as_its_data_scatter(monkeypatch):
    """Data whose variance is four times that of their noise make the deviation of a change twice as large."""
    made = made_of(monkeypatch, [(candidate("com_offset"), i, 0.0) for i in range(3)], 1.0)
    monkeypatch.setattr(numbers, "overdispersion", lambda _: (4.0, np.eye(3)))
    made.linear.observation.healthy = made
    made.changes = (None, None, np.array([0.1, 0.2, 0.0]))
    cls = candidate("com_offset")
    made.members = (Member(cls, cls.absent(VEHICLE)),)
    scale = places(cls, VEHICLE)[0].scale
    assert fitted_numbers(made) == [{"r": pytest.approx([0.2 * scale, 0.4 * scale, 0.0])}]


def test_times_of_the_file_are_no_surer_than_stamps(monkeypatch):
    """A tenth of 10 ms beside 0.5 ms, and what is less than three times as far off is not told."""
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})
    lag = places(candidate("rotor_lag"), VEHICLE)[0].scale
    asked = [(candidate("rotor_lag"), 0, 0.004 / lag), (candidate("time_offset"), 0, 0.2)]
    (told, *_) = file_numbers(made_of(monkeypatch, asked, 0.0005 / lag), ())
    assert told.standard_error == pytest.approx(0.0005)
    (of_lag, *_) = file_numbers(made_of(monkeypatch, asked, 0.0005 / lag, command_step=0.01), ())
    assert of_lag.standard_error == pytest.approx(np.hypot(0.0005, 0.001))
    assert file_numbers(made_of(monkeypatch, asked, 0.0005 / lag, command_step=0.2), ()) == ()
    # Where commands may have run on between the rows, than 3/16 of what is between them, too.
    t = np.arange(0.0, 1.0, 0.005)
    seen = [SimpleNamespace(flight=Flight(pd.DataFrame({"t": t, **{f"cmd_rotor_{i}": 400.0 + t for i in range(4)}})))]
    (of_lag, *_) = file_numbers(made_of(monkeypatch, asked, 0.0005 / lag, command_step=0.005, samples=seen), ())
    assert of_lag.standard_error == pytest.approx(np.linalg.norm([0.0005, 0.0005, 0.005 * 3 / 16]))


def test_thrust_over_mass_is_no_surer_than_the_force_that_stays():
    """0.2 N of a weight of 7.848 N beside 0.1 %; other numbers are as they were."""
    ratio = numbers.FileNumber(f"thrust of all rotors {numbers.OVER_MASS}", 1.0, 0.9, 0.001, True)
    other = numbers.FileNumber("mass", 0.8, 0.9, 0.001, True, "kg")
    weight = VEHICLE.mass * VEHICLE.gravity
    told, same = numbers.beside_what_stays((ratio, other), 0.2, VEHICLE)
    assert told.standard_error == pytest.approx(np.hypot(0.001, 0.9 * 0.2 / weight))
    assert (told.value, same) == (0.9, other)
    assert numbers.beside_what_stays((ratio, other), 0.0, VEHICLE) == (ratio, other)
    # A tenth is no longer off where as much stays as half a newton.
    assert numbers.beside_what_stays((ratio, other), 0.5, VEHICLE) == (other,)


def test_moments_are_unsure_by_half_of_what_thrust_over_mass_is_off_by(monkeypatch):
    """Eight percent less thrust, or more mass: beside the mass moments are eight percent more than beside the other."""
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})
    asked = [
        (candidate("inertia_error"), 1, 0.9),
        (candidate("com_offset"), 1, 0.9),
        (candidate("mass_offset"), 0, 1.6),
    ]
    made = made_of(monkeypatch, asked, 0.02)
    ratio, moment, centre, _mass = file_numbers(made, ())
    monkeypatch.setattr(numbers, "thrust_over_mass", lambda *_, **__: [])
    sure, as_sure, _mass = file_numbers(made, ())
    assert ratio.value == pytest.approx(np.exp(-0.08))
    assert moment.standard_error == pytest.approx(np.hypot(sure.standard_error, 0.04 * moment.value))
    assert centre == as_sure


def test_a_number_is_no_surer_than_half_of_what_it_is_beside_other_names(monkeypatch):
    """With what stands in the place of a name a lag is 8 ms in place of 16, and eight percent of mass are six."""
    monkeypatch.setattr(numbers, "_takes", lambda made, along, faint: {})
    lag = places(candidate("rotor_lag"), VEHICLE)[0].scale
    asked = [(candidate("rotor_lag"), 0, 0.016 / lag), (candidate("mass_offset"), 0, 1.6)]
    other = made_of(monkeypatch, [(candidate("mass_offset"), 0, 1.2), (candidate("rotor_lag"), 0, 0.008 / lag)], 0.001)
    none = made_of(monkeypatch, [(candidate("mass_offset"), 0, 1.6), (candidate("com_offset"), 0, 1.0)], 0.001)
    less = made_of(monkeypatch, [(candidate("mass_offset"), 0, 1.6), (candidate("rotor_lag"), 0, 0.001 / lag)], 0.001)
    made = made_of(monkeypatch, asked, 0.001)
    ratio, alone, mass = file_numbers(made, ())
    wider, told, _ = file_numbers(made, (), others=[other])
    assert told.value == alone.value
    assert told.standard_error == pytest.approx(np.hypot(alone.standard_error, 0.004))
    share = np.hypot(ratio.standard_error / ratio.value, 0.5 * 0.4 * 0.05)
    assert (wider.value, wider.standard_error) == (ratio.value, pytest.approx(share * ratio.value))
    # What another fit does not ask for it does not tell, either. What is no longer off by three errors is not told.
    assert file_numbers(made, (), others=[none]) == (ratio, alone, mass)
    assert [n.name for n in file_numbers(made, (), others=[less])] == [ratio.name, mass.name]


def test_a_number_that_is_out_of_line_is_told_as_an_effect_is():
    """Half a usual size of a centre of mass beside a file that is right to 1 %, a twentieth: the prior holds a part
    of it back, and gives some to a rotor, of which data say nearly the same. Thrust over mass is of several numbers,
    and a model is not linear in times."""

    def rows(rng, _):
        x = rng.standard_normal((ROWS, 5))
        x[:, 2] = 0.15 * x[:, 1]
        x[:, 0] = 0.5 * x[:, 1] + 0.5 * x[:, 3] + 2.0 * x[:, 4]
        return x

    _, whole = linear_fit(["com_offset", "rotor_effectiveness 0", "mass_offset", "actuation_delay"], rows, [])
    scales = Scales(1.0)
    held = replace(whole, scales=scales, solution=whole.linear.scorer(scales).solution(()))
    freed = numbers.out_of_line_freed(held, ())
    assert held.solution.theta[0] < 0.47
    assert freed.labels == ("com_offset",)
    assert freed.solution.theta[:2] == pytest.approx([0.5, 0.0], abs=0.01)
    assert freed.solution.theta[2:] == pytest.approx(held.solution.theta[2:], abs=0.01)
    assert numbers.out_of_line_freed(held, {"com_offset"}) is held
    # Beside what stands for a name it is freed as well: what was held back of it there is no doubt.
    alone, beside = ({n.name: n for n in file_numbers(held, (), others=x)} for x in ((), (held,)))
    assert beside == alone
    assert alone["center_of_mass.x"].value == pytest.approx(
        0.5 * places(candidate("com_offset"), VEHICLE)[0].scale, rel=0.02
    )
