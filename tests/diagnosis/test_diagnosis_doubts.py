"""Doubts about logs and files by hand-made signals: which axes go, what is said, and what is no doubt."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from infotraj.comparing.equation_error import AXES, EquationError
from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.gates.agreement import _correlation, _without_drift, contradictions
from infotraj.diagnosis.gates.doubt import (
    Doubt,
    as_accepted,
    of_residual,
    reached,
    refused_axes,
    with_mixed,
)
from infotraj.diagnosis.gates.impossible_body import impossible_body
from infotraj.diagnosis.gates.level import as_level, unmeasured
from infotraj.diagnosis.gates.premises import _still, _thin, command_step, remaining
from infotraj.diagnosis.gates.saturation import saturated
from infotraj.diagnosis.gates.vehicle_faults import _changed, _fullest, _gain, _variance
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.effects import effect_class
from infotraj.flight import ATTITUDE, RATE, Flight
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
QUAD, OMAV = (load_vehicle(VEHICLES / f"{n}.yaml") for n in ("quadrotor", "omav"))
T = np.arange(0.0, 20.0, 0.01)
SOME = dict(red=np.ones(6), unit={}, force_from="", window=0.15, reasons={}, left_out={})


def waves(*frequencies, late=0.0):
    return sum(np.sin(2 * np.pi * f * (T - late) + 3 * f) for f in frequencies)


def signals():
    """Six axes of unrelated waves, and white noise of 0.01."""
    noise = np.random.default_rng(0).normal(0, 0.01, (len(T), 6))
    return np.stack([waves(0.4 + 0.05 * k, 0.9 + 0.06 * k) for k in range(6)], axis=1), noise


def error(measured, predicted, floor=0.01):
    return EquationError(T, measured, predicted, floor=np.full(6, floor), **SOME)


def found(measured, predicted, vehicle=QUAD):
    return contradictions([error(measured, predicted)], vehicle)


def test_what_is_measured_as_predicted_is_no_doubt():
    made, noise = signals()
    assert found(made + noise, made) == []
    assert found(made + noise, 0.5 * made) == []


def test_an_opposite_prediction_is_said_to_be_one_and_what_follows_is_left():
    made, noise = signals()
    predicted = made.copy()
    predicted[:, 5] *= -1.0
    (doubt,) = found(made + noise, predicted)
    assert doubt.code == "commands_unrelated"
    assert "opposite of what was measured on tz (-1.00)" in doubt.reason
    assert "unrelated" not in doubt.reason
    assert doubt.axes == ("tz",)
    assert doubt.unordered
    # Rotors that tilt make every axis together.
    (every,) = found(made + noise, predicted, OMAV)
    assert every.axes == AXES


def test_a_side_force_that_no_rotor_makes_is_not_asked_of_the_commands():
    """A centre of mass that is not where the file has it predicts one that a turn makes, and of the other sign."""
    made, noise = signals()
    predicted = made.copy()
    predicted[:, :2] *= -1.0
    assert found(made + noise, predicted) == []
    assert "fx (-1.00), fy (-1.00)" in found(made + noise, predicted, OMAV)[0].reason


def test_two_torques_that_are_not_those_of_the_commands_are_a_doubt_and_quiet_ones_are_none():
    made, noise = signals()
    predicted = made.copy()
    predicted[:, 3:5] = np.stack([waves(0.45, 1.9), waves(0.5, 2.1)], axis=1)
    (doubt,) = found(made + noise, predicted)
    assert "unrelated to what was measured on tx" in doubt.reason
    assert set(doubt.axes) == {"tx", "ty"}
    # Nothing is asked of what lies below five times its noise, on either side.
    small = np.array([1.0, 1.0, 1.0, 0.04, 0.04, 1.0])
    assert found(made * small + noise, predicted) == []
    assert found(made + noise, predicted * small) == []


def test_torques_that_hold_against_the_air_are_those_of_the_commands_where_the_fast_part_of_them_turns_the_vehicle():
    made, noise = signals()
    fast = np.stack([waves(0.45, 3.1), waves(0.5, 2.7)], axis=1)
    against = np.zeros_like(made)
    against[:, 3:5] = 4.0 * np.stack([waves(0.62, 0.71), waves(0.66, 0.75)], axis=1)
    measured = made.copy()
    measured[:, 3:5] = fast
    assert found(measured + noise, measured + against) == []
    # Another order of the rotors: what turns the vehicle at once is not what they predict.
    swapped = measured.copy()
    swapped[:, 3:5] = measured[:, 4:2:-1]
    (doubt,) = found(measured + noise, swapped + against)
    assert set(doubt.axes) >= {"tx", "ty"}


def test_a_fast_torque_that_is_the_opposite_is_none_that_comes_half_a_period_later():
    made, noise = signals()
    shaken = np.stack([waves(0.45, 7.0), waves(0.5, 7.3)], axis=1)
    measured, wrong = made.copy(), made.copy()
    measured[:, 3:5], wrong[:, 3:5] = shaken, -shaken
    assert found(measured + noise, measured) == []
    (doubt,) = found(measured + noise, wrong)
    assert set(doubt.axes) >= {"tx", "ty"}


def test_a_prediction_far_smaller_than_what_is_measured_does_not_claim_to_explain_it():
    """Unless that is so on most axes that are loud."""
    made, noise = signals()
    other = np.stack([waves(0.43 + 0.07 * k, 2.0 + 0.1 * k) for k in range(6)], axis=1)
    one = np.where(np.isin(np.arange(6), [0, 1]), 0.2 * other, made)
    assert found(made + noise, one) == []
    (doubt,) = found(made + noise, 0.2 * other)
    assert "unrelated" in doubt.reason


@pytest.mark.parametrize("late", [0.1, -0.2])
def test_a_correlation_is_that_of_what_was_predicted_before(late):
    a, b = waves(0.7, 1.9), waves(0.7, 1.9, late=-late)
    assert _correlation([(a, b)], round(late / 0.01)) == pytest.approx(1.0, abs=1e-9)
    assert _correlation([(a, b)], -round(late / 0.01)) < 0.8
    assert _correlation([(3.0 * a, 0.1 * b)], round(late / 0.01)) == pytest.approx(1.0, abs=1e-9)


def test_slow_changes_are_left_out_and_fast_ones_are_not():
    """Over 2 s: a straight line goes, and three periods in that time stay."""
    inside = slice(200, -200)
    np.testing.assert_allclose(_without_drift(3.0 + 0.5 * T, 200)[inside], 0.0, atol=1e-9)
    fast = waves(1.5)
    np.testing.assert_allclose(_without_drift(fast, 200)[inside], fast[inside], atol=0.02)
    assert np.abs(_without_drift(waves(0.05), 200)[inside]).max() < 0.02


def doubt(*axes, reason="why", code="x", **more):
    return Doubt(code, "about", axes, reason, **more)


def test_a_doubt_that_is_accepted_or_only_said_refuses_nothing():
    both = [doubt("tz", "fx", reason="one"), doubt("tz", "ty", reason="two")]
    assert list(refused_axes(both).items()) == [("fx", "one"), ("ty", "two"), ("tz", "one")]
    assert refused_axes([doubt("fx", refuses=False), doubt("fy", accepted=True)]) == {}


def test_a_doubt_is_accepted_where_every_flight_accepts_it():
    one, two = (
        Flight(pd.DataFrame({"t": [0.0, 1.0]}), {"accept": codes})
        for codes in (["hovers", "axis_disagrees"], ["hovers"])
    )
    marked = as_accepted([doubt("fx", code="axis_disagrees"), doubt("fy", code="hovers")], [one, two])
    assert [d.accepted for d in marked] == [False, True]


def test_a_force_that_is_measured_in_the_worlds_axes_is_refused_with_its_neighbours():
    samples = [SimpleNamespace(channels=[SimpleNamespace(name="velocity")])]
    assert with_mixed({"fy": "a", "fz": "b", "tz": "c"}, samples) == {"fx": "a", "fy": "a", "fz": "b", "tz": "c"}
    assert with_mixed({"fy": "a"}, []) == {"fy": "a"}
    assert with_mixed({"tz": "c"}, samples) == {"tz": "c"}
    assert of_residual(["fx", "tz"]) == {"fx", "vx", "tz"}


def test_actuators_reach_the_axes_along_which_they_push_and_every_torque():
    assert reached(QUAD) == ("fz", "tx", "ty", "tz")
    assert reached(OMAV) == AXES
    turned = [r.model_copy(update={"axis": (0.0, 0.1, 0.995)}) if i == 0 else r for i, r in enumerate(QUAD.rotors)]
    assert reached(QUAD.model_copy(update={"rotors": tuple(turned)})) == ("fy", "fz", "tx", "ty", "tz")


def flight(**columns):
    return Flight(pd.DataFrame({"t": T, **columns}))


def test_a_place_alone_makes_a_vehicle_level_and_still_and_says_so():
    made = as_level(flight(px=T, py=0.0, pz=1.0))
    assert made.get(*RATE).tolist() == np.zeros((len(T), 3)).tolist()
    assert set(made.meta["derived"]) == {*ATTITUDE, *RATE}
    # Rates that were measured stay; without a place nothing is said.
    rates = as_level(flight(px=T, py=0.0, pz=1.0, wx=T, wy=T, wz=T))
    assert rates.get("wx")[:, 0].tolist() == T.tolist()
    assert unmeasured(rates) == (frozenset({"vx", "vy"}), frozenset({"vz"}))
    turned = flight(px=T, py=0.0, pz=1.0, qw=1.0, qx=0.0, qy=0.0, qz=0.0)
    assert as_level(turned) is turned
    assert as_level(flight(wx=T, wy=T, wz=T)).meta == {}
    speed = as_level(flight(vx=T, vy=0.0, vz=1.0))
    assert unmeasured(speed) == unmeasured(made)


def still(**columns):
    return _still(flight(**columns), np.ones(len(T), dtype=bool))


def test_a_vehicle_is_still_that_neither_turns_tilts_nor_moves():
    rng = np.random.default_rng(0)
    rates = {f"w{a}": 0.08 * rng.standard_normal(len(T)) for a in "xyz"}
    place = {f"p{a}": 0.1 * np.sin(0.5 * T) for a in "xyz"}
    level = {"qw": np.ones(len(T)), "qx": 0.0 * T, "qy": 0.0 * T, "qz": 0.0 * T}
    assert still(**rates, **place, **level)
    assert not still(**{**rates, "wz": 0.25 * np.sin(T)}, **place, **level)
    for axis in ("qx", "qy", "qz"):
        half = 0.5 * 0.12 * np.sin(T)  # rad: a deviation of 0.08
        assert not still(**rates, **place, **{**level, "qw": np.cos(half), axis: np.sin(half)}), axis
        assert still(**rates, **place, **{**level, "qw": np.cos(half / 3), axis: np.sin(half / 3)}), axis
    assert not still(**rates, **{**place, "pz": 0.2 * np.sin(0.5 * T)}, **level)
    velocity = {f"v{a}": 0.1 * np.sin(T) for a in "xyz"}
    assert still(**rates, **velocity, **level)
    # For a tenth of the time it moves fast.
    assert not still(**rates, **{**velocity, "vx": np.where(T < 2.0, 1.0, 0.0)}, **level)
    assert still(**rates, **{**velocity, "vx": np.where(T < 0.5, 1.0, 0.0)}, **level)


def test_without_an_attitude_a_force_that_changes_is_motion_and_white_noise_is_none():
    rng = np.random.default_rng(0)
    force = {f"a{a}": 0.5 * rng.standard_normal(len(T)) for a in "xyz"}
    assert still(**force)
    assert not still(**{**force, "ax": force["ax"] + 0.6 * np.sin(T)})
    assert not _still(flight(), np.ones(len(T), dtype=bool))
    assert _still(flight(), np.zeros(len(T), dtype=bool))
    assert not _still(flight(**force), T < 0.3)


def commands(every, hold=False, count=4):
    """A new command of each rotor every so many rows."""
    rng = np.random.default_rng(1)
    rows = np.arange(len(T))
    values = rng.uniform(400.0, 600.0, (len(T), count))[rows // every * every]
    if not hold:
        values[rows % every != 0] = np.nan
    return {f"cmd_rotor_{i}": values[:, i] for i in range(count)}


@pytest.mark.parametrize("hold", [True, False])
def test_actuators_that_are_known_less_than_every_30_ms_do_not_say_what_they_did(hold):
    rows = np.ones(len(T), dtype=bool)
    assert _thin(flight(**commands(2, hold)), rows, QUAD) is None
    doubt = _thin(flight(**commands(4, hold)), rows, QUAD)
    assert "every 40 ms only (25 Hz)" in doubt.reason
    assert doubt.axes == reached(QUAD)


def test_the_time_between_commands_is_the_median_of_rows_that_hold_them():
    made = commands(2)
    for column in made.values():
        column[1000:1200] = np.nan
    assert command_step(flight(**made), QUAD) == pytest.approx(0.02)
    assert command_step(flight(), QUAD) == 0.0


def test_tilts_that_never_change_are_no_doubt_and_rotors_are():
    tilts = {f"cmd_tilt_{i}": np.zeros(len(T)) for i in range(6)}
    rows = np.ones(len(T), dtype=bool)
    assert _thin(flight(**commands(1, count=12), **tilts), rows, OMAV) is None
    constant = {f"cmd_rotor_{i}": np.full(len(T), 500.0) for i in range(12)}
    assert "never change" in _thin(flight(**constant, **tilts), rows, OMAV).reason


def candidate(name, *fixed):
    cls = effect_class(name)
    return Candidate(cls, tuple(p for p in cls.parameters if not p.index), fixed)


def test_where_the_order_of_columns_is_not_known_no_single_actuator_is_asked_about():
    known = [candidate("linear_drag"), candidate("rotor_effectiveness", ("rotor", 1)), candidate("servo_bias")]
    names = [c.name for c in known]
    left, hidden = remaining([doubt("tz", unordered=True)], names, known, {"wind": "no"})
    assert [c.name for c in left] == ["linear_drag"]
    assert hidden == {"wind": "no", "rotor_effectiveness": "why", "servo_bias": "why"}
    assert remaining([doubt("tz")], names, known, {}) == (known, {})
    nothing, hidden = remaining([doubt(*AXES)], [*names, "wind"], known, {"wind": "no"})
    assert nothing == []
    assert hidden == {**dict.fromkeys(names, "why"), "wind": "no"}


def throttles(share, monkeypatch, most=0.99):
    """Two flights of four throttles: the second rotor is at `most` for this share of the first flight."""
    vehicle = QUAD.model_copy(update={"rotors": tuple(r.model_copy(update={"input": "throttle"}) for r in QUAD.rotors)})
    high = np.where(np.arange(len(T)) < share * len(T), most, 0.6)
    made = [
        flight(**{f"cmd_rotor_{i}": high if (i, k) == (1, 0) else np.full(len(T), 0.6) for i in range(4)})
        for k in range(2)
    ]
    monkeypatch.setattr(
        "infotraj.diagnosis.gates.saturation.airborne_rows", lambda f, v: SimpleNamespace(rows=np.ones(len(T)))
    )
    return saturated(made, vehicle)


def test_a_rotor_that_is_at_full_throttle_for_a_fiftieth_of_a_flight_is_said(monkeypatch):
    (said,) = throttles(0.05, monkeypatch)
    assert said.reason.startswith("rotor_1 is at full throttle in 5 % of a flight")
    assert not said.counts
    assert throttles(0.01, monkeypatch) == []


def test_the_most_that_an_autopilot_gives_is_full_throttle(monkeypatch):
    """ArduPilot's motors end at MOT_SPIN_MAX, 0.95. A motor that is never held at its most is not at its end."""
    (said,) = throttles(0.05, monkeypatch, most=0.95)
    assert said.reason.startswith("rotor_1 is at full throttle in 5 % of a flight")
    assert throttles(0.05, monkeypatch, most=0.7) == []
    assert throttles(0.05, monkeypatch, most=np.linspace(0.9, 2.1, len(T))) == []


def unanswered(monkeypatch, measured, predicted, vehicle=QUAD, given=None, **more):
    """Doubts about a model whose errors are these; `given`: those of the model before the fit."""
    made = {"fitted": [error(measured, predicted)], "given": None if given is None else [error(measured, given)]}
    monkeypatch.setattr(refusal, "compared", lambda model, *_: made[model.name])
    models = [SimpleNamespace(vehicle=vehicle, name=n) for n in ("fitted", "given")]
    before = None if given is None else models[1]
    return refusal.unanswered(models[0], [], given=before, **more)


def test_an_axis_is_refused_whose_prediction_says_much_and_explains_nothing(monkeypatch):
    made, noise = signals()
    predicted = made.copy()
    predicted[:, 5] = waves(0.77, 2.3)
    (doubt,) = unanswered(monkeypatch, made + noise, predicted)
    assert (doubt.axes, doubt.code) == (("tz",), "axis_disagrees")
    assert "0 % of the measured torque about z" in doubt.reason
    assert unanswered(monkeypatch, made + noise, predicted, given=made) == []
    assert unanswered(monkeypatch, made + noise, predicted, known={"tz"}) == []
    # Neither an error near the floor nor a prediction below it says that.
    assert unanswered(monkeypatch, 0.02 * made + noise, 0.02 * predicted) == []
    assert unanswered(monkeypatch, made + noise, predicted * [1, 1, 1, 1, 1, 0.01]) == []
    # Beside actuators that do not push there an axis is not asked.
    beside = made.copy()
    beside[:, 0] = predicted[:, 5]
    assert unanswered(monkeypatch, made + noise, beside) == []


def test_what_goes_with_the_measured_side_explains_it_whatever_its_size(monkeypatch):
    """An axis whose error is twice what was measured, and whose prediction is three times that, agrees."""
    made, noise = signals()
    assert unanswered(monkeypatch, made + noise, made * [1, 1, 1, 3, 1, 1]) == []
    # A steady part of either side says nothing of what goes with the other.
    (doubt,) = unanswered(
        monkeypatch, made + noise + 5.0, np.where(np.arange(6) == 3, waves(0.44)[:, None] + 5.0, made)
    )
    assert doubt.axes == ("tx",)


def test_a_thrust_that_carries_the_weight_explains_it_whatever_a_hover_shows_of_its_changes(monkeypatch):
    made, noise = signals()
    along_z = np.eye(6)[2]
    measured, predicted = made + noise + 50.0 * along_z, np.where(along_z > 0, waves(0.77, 2.3)[:, None], made)
    assert unanswered(monkeypatch, measured, predicted + 50.0 * along_z) == []
    (doubt,) = unanswered(monkeypatch, measured, predicted + 1.0 * along_z)
    assert doubt.axes == ("fz",)


def test_a_torque_that_tilting_rotors_do_not_make_leaves_no_axis_sure(monkeypatch):
    made, noise = signals()
    predicted = made.copy()
    predicted[:, 4] = waves(0.77, 2.3)
    (doubt,) = unanswered(monkeypatch, made + noise, predicted, OMAV)
    assert doubt.axes == AXES
    only_force = made.copy()
    only_force[:, 1] = predicted[:, 4]
    (doubt,) = unanswered(monkeypatch, made + noise, only_force, OMAV)
    assert doubt.axes == ("fy",)


def test_which_force_an_axis_stands_for():
    assert [refusal.axis_group(a) for a in ("vx", "vy", "vz", "tx", "turn x")] == ["fx", "fy", "fz", "tx", None]


def test_a_change_of_the_file_gains_by_the_logarithm_of_variances_and_not_where_little_falls():
    floor, now = np.zeros(6), np.array([np.nan, 1.0, 1.0, 4.0, 1.0, 1.0])
    assert _gain(now, now * [1, 1, 1, 0.25, 1, 1], floor) == pytest.approx(np.log(4.0))
    assert _gain(now, now * [1, 1, 1, 0.25, 2, 1], floor) == pytest.approx(np.log(2.0))
    assert _gain(now, now * [1, 1, 1, 0.25, 8, 1], floor) == 0.0
    assert _gain(now, now * [1, 1, 1, 0.7, 0.7, 0.7], floor) == 0.0
    # What lies below the floor is no gain.
    assert _gain(now, now * [1, 1, 1, 0.001, 1, 1], np.full(6, 2.0)) == pytest.approx(np.log(8.0 / 4.004))


def test_what_is_steady_is_no_fault_of_the_file():
    made, _ = signals()
    assert _variance(error(made + 7.0, np.zeros_like(made))) == pytest.approx(made.var(axis=0))


def test_the_part_is_looked_at_that_can_be_compared_nearest_to_the_middle():
    used = np.arange(0.0, 30.0, 0.01)
    assert _fullest(used) == pytest.approx(12.0, abs=0.02)
    assert 20.0 <= _fullest(used[(used > 20.0) | (used % 1.0 < 0.2)]) <= 24.1


def test_an_inertia_that_no_body_has_is_said_and_refuses_nothing():
    assert impossible_body(QUAD) == []
    zz = 1.1 * (QUAD.inertia.xx + QUAD.inertia.yy)
    (doubt,) = impossible_body(QUAD.model_copy(update={"inertia": QUAD.inertia.model_copy(update={"zz": zz})}))
    assert (doubt.code, doubt.axes, doubt.refuses) == ("impossible_inertia", (), False)
    assert "one moment is 10 % larger" in doubt.reason
    assert impossible_body(QUAD.model_copy(update={"inertia": None})) == []


def test_every_wrong_entry_is_tried_once():
    words = [w for w, _ in _changed(QUAD, every=False)]
    assert words == ["all spins reversed", *(f"the spin of rotor_{i} reversed" for i in range(4))]
    made = dict(_changed(QUAD, every=True))
    assert len(made) == 5 + 6
    swapped = made["rotor_0 and rotor_2 in each other's place"].rotors
    assert [swapped[0], swapped[1], swapped[2]] == [QUAD.rotors[2], QUAD.rotors[1], QUAD.rotors[0]]
    assert [r.spin for r in made["all spins reversed"].rotors] == [-r.spin for r in QUAD.rotors]
    tilting = dict(_changed(OMAV, every=True))
    assert tilting["all tilt axes reversed"].tilts[3].axis == tuple(-a for a in OMAV.tilts[3].axis)
    names = [t.name for t in OMAV.tilts]
    assert tilting[f"{names[1]} and {names[4]} in each other's place"].tilts[1] == OMAV.tilts[4]
    assert tilting[f"{names[1]} and {names[4]} in each other's place"].tilts[4] == OMAV.tilts[1]
