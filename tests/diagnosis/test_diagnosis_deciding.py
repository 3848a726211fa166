"""What stands when the model that is given takes a name away or differs: a rival that is impossible is none."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.judge import deciding
from infotraj.diagnosis.judge.deciding import _demoted, _labels, _others, _with_apart, _with_held_back
from infotraj.diagnosis.judge.groups import Rival
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.flight import read_flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

PAIR = ("mass_offset", "thrust_scale")


def alike(names):
    return tuple(Finding(n, "Not separable", names, None, {}, {}, "cannot tell") for n in names)


@pytest.mark.parametrize(("impossible", "verdict"), [({"thrust_scale"}, "Supported"), (set(), "Plausible")])
def test_what_is_left_of_a_group_is_sure_only_where_the_other_is_impossible(impossible, verdict):
    mass, thrust = _demoted(alike(PAIR), {"thrust_scale": "why it went"}, impossible)
    assert (thrust.verdict, thrust.reason) == ("Plausible", "why it went")
    assert (mass.verdict, mass.group) == (verdict, ("mass_offset",))
    assert ("why it went" in mass.reason) == (verdict == "Plausible")


def test_of_three_alike_two_stay_a_group():
    left = _demoted(alike((*PAIR, "battery_sag")), {"thrust_scale": "why it went"}, {"thrust_scale"})
    assert [f.verdict for f in left] == ["Not separable", "Plausible", "Not separable"]
    assert left[0].group == ("mass_offset", "battery_sag")


def gains(monkeypatch, **of_base):
    """`given` without its fits: a model made around a base predicts as well as that is said to."""

    def made(search, base, labels):
        return SimpleNamespace(base=base.name, gain=of_base[base.name])

    monkeypatch.setattr(deciding, "given", made)


@pytest.mark.parametrize(("gain", "base"), [(TELLS + 0.1, "other"), (TELLS - 0.1, "told"), (-1.0, "told")])
def test_the_model_is_made_around_what_stands_for_a_group_where_it_predicts_better(monkeypatch, gain, base):
    told = SimpleNamespace(name="told", labels=("coaxial_loss", "linear_drag"))
    stand = {"thrust_scale": SimpleNamespace(label="thrust_scale", fit=SimpleNamespace(name="other"))}
    gains(monkeypatch, told=1.0, other=1.0 + gain)
    assert vars(deciding._made(None, told, ["linear_drag", "thrust_scale"], stand))["base"] == base
    assert vars(deciding._made(None, told, ["linear_drag", "coaxial_loss"], stand))["base"] == "told"


def supported(name, parameters, errors):
    return Finding(name, "Supported", (name,), None, parameters, errors)


def model_given(**effects):
    """What `_with_apart` asks of the model that is given: its members by label, none held back."""
    made = [
        SimpleNamespace(
            candidate=SimpleNamespace(label=label.replace("_3", " 3"), **of), effect=SimpleNamespace(values=v)
        )
        for label, (of, v) in effects.items()
    ]
    observation = SimpleNamespace(healthy=None)
    return SimpleNamespace(
        fit=SimpleNamespace(members=made, linear=SimpleNamespace(observation=observation)), held_back={}
    )


def form(*names, **fixed):
    return {"form": [SimpleNamespace(name=n) for n in names], "fixed": tuple(fixed.items())}


def test_a_number_that_the_new_model_has_elsewhere_is_as_uncertain_as_the_two_differ():
    """Half of the difference is the deviation of two values that are as likely; what agrees keeps its error."""
    findings = (
        supported("mass_offset", {"dm": 1.3}, {"dm": 0.3}),
        supported("linear_drag", {"d": [0.1, 0.2, 0.3]}, {"d": [0.01, 0.01, 0.03]}),
        supported("rotor_effectiveness", {"rotor": 3, "factor": 0.8}, {"factor": 0.01}),
        Finding("wind", "Plausible", ("wind",), None, {"v": 1.0}, {"v": 0.1}),
    )
    made = model_given(
        mass_offset=(form("dm"), {"dm": 2.1}),
        linear_drag=(form("d"), {"d": [0.1, 0.2, 0.38]}),
        rotor_effectiveness_3=(form("factor", rotor=3), {"rotor": 3, "factor": 0.8}),
        wind=(form("v"), {"v": 5.0}),
    )
    mass, drag, rotor, wind = _with_apart(findings, made, ())
    assert mass.standard_errors["dm"] == pytest.approx(0.5)
    assert drag.standard_errors["d"] == pytest.approx([0.01, 0.01, 0.05])
    assert rotor.standard_errors == {"factor": pytest.approx(0.01)}
    assert wind.standard_errors == {"v": 0.1}


def test_a_number_is_as_uncertain_as_what_flights_cannot_tell_from_another_name_makes_it():
    """Beside a thrust that is smaller inertias are smaller, beside a larger mass they are not: against healthy flights,
    too."""
    inertia = supported("inertia_error", {"dxx": -0.5, "dyy": 0.0}, {"dxx": 0.03, "dyy": 0.01})
    beside_mass = model_given(
        inertia_error=(form("dxx", "dyy"), {"dxx": 0.3, "dyy": 0.0}), mass_offset=(form("dm"), {"dm": 0.1})
    )
    made = model_given(inertia_error=(form("dxx", "dyy"), {"dxx": 9.0, "dyy": 9.0}))
    made.fit.linear.observation.healthy = object()
    stand = {"mass_offset": Rival("mass_offset", beside_mass.fit)}
    # Whichever of the group comes first; what is not told with confidence says nothing.
    for order in (("mass_offset", "thrust_scale"), ("thrust_scale", "mass_offset")):
        named = (inertia, *alike(order))
        found, *_ = _with_apart(named, made, _others(named, stand))
        assert found.standard_errors == {"dxx": pytest.approx(np.hypot(0.03, 0.4)), "dyy": pytest.approx(0.01)}
    plausible = Finding("mass_offset", "Plausible", ("mass_offset",), None, {}, {})
    assert _with_apart((inertia, plausible), made, _others((inertia, plausible), stand))[0].standard_errors == {
        "dxx": 0.03,
        "dyy": 0.01,
    }


def test_what_is_held_back_is_said_of_what_is_named_beside_its_own_reason():
    pair = alike(PAIR)
    plausible = Finding("wind", "Plausible", ("wind",), None, {}, {}, "little")
    held = {"thrust_scale 0": "without it", "wind": "without it"}
    mass, thrust, wind = _with_held_back((*pair, plausible), held)
    assert (mass.reason, thrust.reason, wind.reason) == ("cannot tell", "cannot tell; without it", "little")


def test_labels_are_those_of_the_set_and_of_rivals_that_stand_for_a_name():
    told = SimpleNamespace(labels=("rotor_effectiveness 0", "rotor_effectiveness 3", "linear_drag"))
    stand = {"mass_offset": "mass_offset", "wind": "wind", "linear_drag": "linear_drag"}
    labels = _labels(told, ["rotor_effectiveness", "mass_offset", "linear_drag"], stand)
    assert labels == ["rotor_effectiveness 0", "rotor_effectiveness 3", "linear_drag", "mass_offset"]


@pytest.mark.long
@pytest.mark.parametrize("flight", [0, 1, 2])
def test_nothing_is_named_where_the_model_as_given_predicts_as_well(flight):
    """Of one flight of eight seconds sets are found whose members make up for one another."""
    folder = Path(__file__).parents[2] / "examples/quad"
    given = Model(load_vehicle(folder / "vehicle.yaml"))
    found = diagnose(given, [read_flight(folder / f"healthy/flight_{flight}.parquet")])
    assert found.supported == ()
