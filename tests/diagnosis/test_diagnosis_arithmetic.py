"""Small parts of the diagnosis by numbers that can be worked out by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from infotraj.comparing.equation_error import EquationError
from infotraj.diagnosis.gates.refusal import coherence
from infotraj.diagnosis.judge import numbers
from infotraj.diagnosis.judge.evidence import resampled
from infotraj.diagnosis.judge.worse import worse_lines
from infotraj.diagnosis.linear.healthy import Healthy
from infotraj.diagnosis.select.prior import Scales
from infotraj.vehicle import OF_ROTORS


def test_what_goes_against_the_prediction_does_not_go_with_it():
    measured = np.random.default_rng(0).normal(0, 1, (100, 6))
    some = dict(floor=np.ones(6), red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})
    t = 0.1 * np.arange(100)
    assert coherence([EquationError(t, measured, -measured, **some)]) == pytest.approx(0.0)
    assert coherence([EquationError(t, measured, 0.3 * measured, **some)]) == pytest.approx(1.0)


def test_blocks_are_drawn_within_their_flights():
    flight = np.repeat([0, 1, 2], [3, 5, 8])
    drawn = resampled(flight, np.random.default_rng(0), 200)
    for f, blocks in enumerate((3, 5, 8)):
        assert (drawn[:, flight == f].sum(axis=1) == blocks).all()
    assert drawn.mean(axis=0) == pytest.approx(1.0, abs=0.3)


def test_a_flight_alone_may_differ_by_what_healthy_flights_differ_by():
    owners = (("a", 0), ("b", 1))
    covariance, scatter = np.array([[0.04, 0.01], [0.01, 0.09]]), np.array([0.5, 0.2])
    healthy = Healthy({}, owners, np.zeros(2), covariance, scatter, frozenset(), ())
    columns = [("b", 1), ("c", 0), ("a", 0), ("b", 1)]
    alone, several = (healthy.prior(columns, alone=x) for x in (True, False))
    assert several[np.ix_([2, 0], [2, 0])] == pytest.approx(covariance)
    assert np.diag(alone - several) == pytest.approx([0.04, 0.0, 0.25, 0.0])


def test_healthy_flights_leave_the_candidates_that_they_showed_each_rotor_by_itself():
    known = [SimpleNamespace(name=x.split()[0], label=x) for x in ("drag", "rotor 0", "rotor 3", "lag")]
    owners = (("rotor 0", 0), ("drag", 1), ("rotor 3", 0))
    healthy = Healthy({}, owners, np.zeros(3), np.eye(3), np.zeros(3), frozenset(), ())
    left, hidden = healthy.shown(known, {"sag": "no voltage"})
    assert [c.label for c in left] == ["drag", "rotor 0", "rotor 3"]
    assert hidden == {"sag": "no voltage", "lag": "the healthy flights cannot show it"}


def test_axes_that_get_worse_are_those_whose_error_grows():
    before, after = np.ones(6), np.array([0.1, 2.0, 1.0, np.nan, 5.0, 1.0])
    said = worse_lines(SimpleNamespace(rmse=before), SimpleNamespace(rmse=after))
    assert list(said) == ["fy", "ty"]
    assert said["fy"].startswith("fy is worse with the new model: ")


def candidate(label):
    name, *rotor = label.split()
    return SimpleNamespace(name=name, label=label, fixed=tuple(("rotor", int(r)) for r in rotor))


def test_a_vehicle_that_is_heavier_than_its_file_has_less_thrust_over_mass_and_stronger_rotors_have_more(monkeypatch):
    names = ["mass_offset", "rotor_effectiveness 0", "rotor_effectiveness 1"]
    columns = [SimpleNamespace(candidate=candidate(x), scale=s) for x, s in zip(names, (0.08, 1.0, 1.0), strict=True)]
    rotors = [SimpleNamespace(input="speed", thrust_coefficient=k, thrust_polynomial=None) for k in (1.0e-6, 3.0e-6)]
    vehicle = SimpleNamespace(mass=0.8, rotors=rotors, drive=OF_ROTORS)
    linear = SimpleNamespace(
        columns=columns, observation=SimpleNamespace(vehicle=vehicle), spike=lambda scales: np.full(3, 0.01)
    )
    monkeypatch.setattr(numbers, "variance_along", lambda made, weight: 1e-6 * weight @ weight)

    def told(*theta, labels=()):
        made = SimpleNamespace(linear=linear, labels=labels, solution=SimpleNamespace(theta=np.array(theta)))
        (found,) = numbers.thrust_over_mass(made, scales=Scales(1.0))
        return found

    assert told(0.5, 0.0, 0.0).value == pytest.approx(np.exp(-0.05))
    # Thrusts are added, each as large as the file has it.
    assert told(0.0, 0.1, 0.04).value == pytest.approx(0.25 * np.exp(0.1) + 0.75 * np.exp(0.04))
    assert told(0.0, 0.1, 0.04).name == "thrust of all rotors over mass, factor"
    # A rotor that is named has its thrust by that name: of the others no less is told.
    others = told(0.5, -0.2, 0.04, labels=("rotor_effectiveness 0",))
    assert others.value == pytest.approx(np.exp(0.04 - 0.05))
    assert others.name == "thrust of the other rotors over mass, factor"
