"""Held, dead and odd channels: what is no sample becomes an empty cell, and the rest of the flight is used."""

from dataclasses import replace
from pathlib import Path

import fast_flyer
import numpy as np
import pandas as pd
import pytest
from channel_faults import CODES, FAULTS, HEALTHY, changed, held, measured, rounded, stands
from check_flights import A, P, Q, V, W, simulated

from infotraj.checking import examine
from infotraj.checking.airborne import airborne_rows
from infotraj.checking.cleaning import cleaned
from infotraj.checking.columns import dead_columns
from infotraj.checking.held import held_streams
from infotraj.checking.report import as_json
from infotraj.comparing import equation_error
from infotraj.comparing.rollouts import mean_errors, parse_horizons, rollouts
from infotraj.diagnosis.gates import premises
from infotraj.flight import Flight
from infotraj.importing import derive
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

QUADROTOR = Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml"
MOTORS = [f"cmd_rotor_{k}" for k in range(4)]


def found(result, code):
    (finding,) = [f for f in result.findings if f.code == code]
    return finding


def empty(flight, columns):
    return flight.table[list(columns)].isna().to_numpy()


@pytest.fixture(scope="module")
def flown():
    """A flight whose sensors are held over five rows, and the same flight with these rows emptied by hand."""
    flight = Flight(fast_flyer.fly(QUADROTOR, 8.0, 3, {"linear_drag": 0.1}))
    holding = held(flight, [*P, *Q, *V, *W, *A], 5)
    true = holding.table.copy()
    true.loc[np.arange(len(true)) % 5 != 0, [*P, *Q, *V, *W, *A]] = np.nan
    return holding, Flight(true)


def test_held_poses_are_not_stuck_and_their_repeated_rows_are_no_samples():
    flight = held(simulated(3, rate_hz=500.0, duration=12.0), [*P, *Q, *V], 5)
    result = examine(flight)
    assert result.outcome == "passed"
    assert not {"stuck", "dead_stream"} & {f.code for f in result.findings}
    assert result.rates["px..pz"]["hz"] == pytest.approx(100, rel=0.01)
    assert result.rates["px..pz"]["held_from_hz"] == pytest.approx(500, rel=0.01)
    assert result.rates["wx..wz"]["held_from_hz"] is None
    assert as_json([result])["logs"][0]["rates"]["wx..wz"]["hz"] == pytest.approx(500, rel=0.01)
    used = cleaned(flight, result)
    repeats = np.arange(len(flight.t)) % 5 != 0
    assert (empty(used, [*P, *Q, *V]) == repeats[:, None]).all()
    assert not empty(used, [*W, *A, *MOTORS]).any()


def test_a_stream_held_at_an_uneven_rate_and_with_jitter_is_recognised():
    flight = held(simulated(4, rate_hz=250.0, duration=12.0), [*P, *Q], 3.3, jitter=0.2, phase=0.7)
    rates = examine(flight).rates
    assert rates["px..pz"]["hz"] == pytest.approx(250 / 3.3, rel=0.03)
    assert rates["vx..vz"]["held_from_hz"] is None


def test_a_sensor_that_dies_in_a_held_stream_is_still_stuck():
    flight = held(simulated(5, rate_hz=200.0, duration=16.0), [*P, *Q, *V], 4)
    for column in V:
        flight = stands(flight, column, 7.0, 12.0)
    finding = found(examine(flight), "stuck")
    assert finding.severity == "cut"
    assert finding.spans[0] == pytest.approx((7.0, 12.0), abs=0.05)


@pytest.mark.parametrize("kind", HEALTHY)
def test_steps_and_rest_are_no_holds_and_no_deaths(kind):
    flight = HEALTHY[kind](measured(11), np.random.default_rng(0))
    assert not [f.code for f in examine(flight).findings if f.code in CODES]


def test_a_quantised_vehicle_on_the_ground_is_not_held():
    rng = np.random.default_rng(2)
    t = np.arange(0, 20, 0.01)
    table = {"t": t} | {c: 0.01 * np.round(rng.normal(0, 0.3, len(t))) for c in (*W, *P)}
    held_ = held_streams(Flight(pd.DataFrame(table)), np.ones(len(t), dtype=bool))
    assert not any(h.rows.any() for h in held_)


@pytest.mark.parametrize("kind", FAULTS)
def test_a_channel_fault_is_found_and_costs_only_its_own_cells(kind):
    fault = FAULTS[kind]
    flight = fault.make(measured(21, fault.rate_hz), np.random.default_rng(5))
    result = examine(flight)
    assert result.outcome in ("passed", "warning")
    named = {c for f in result.findings if f.code == fault.code for c in f.channels}
    assert set(fault.columns) <= named
    others = [c for c in flight.table if c not in named and c != "t"]
    lost = empty(cleaned(flight, result), others) & ~empty(flight, others)
    assert lost.mean() < 1e-3


def test_a_dead_rotor_column_is_empty_where_it_is_dead():
    flight = stands(measured(22), "rotor_1", 7.0, 13.0, 0.0)
    result = examine(flight)
    finding = found(result, "dead_column")
    assert finding.severity == "warning"
    assert "without commands nothing is predicted" in finding.effect
    dead = empty(cleaned(flight, result), ["rotor_1"])[:, 0]
    assert (dead == ((flight.t >= 7.0) & (flight.t < 13.0))).mean() > 0.999
    with_commands = stands(measured(22, commands=True), "rotor_1", 7.0, 13.0, 0.0)
    assert "rest on the commands" in found(examine(with_commands), "dead_column").effect


def test_nothing_is_predicted_where_a_measured_rotor_is_unknown():
    table = fast_flyer.fly(QUADROTOR, 6.0, 4)
    table = table.rename(columns={f"cmd_rotor_{k}": f"rotor_{k}" for k in range(4)})
    table.loc[(table["t"] > 2) & (table["t"] < 4), "rotor_2"] = np.nan
    covered = Model(load_vehicle(QUADROTOR)).predict(Flight(table)).covered
    inside = (table["t"] > 2.01) & (table["t"] < 3.99)
    assert not covered[inside].any()
    assert covered[~inside & (table["t"] < 5.9)].mean() > 0.98


def test_a_rotor_that_is_idle_or_saturated_is_not_dead():
    flight = measured(23)
    limited = changed(
        flight, rotor_0=np.clip(flight.get("rotor_0")[:, 0], None, np.quantile(flight.get("rotor_0"), 0.6))
    )
    assert "dead_column" not in {f.code for f in examine(limited).findings}


def test_coarse_telemetry_between_the_rows_of_a_faster_sensor_is_not_dead_and_a_column_that_stops_is():
    """Speeds of 48 Hz in steps of 9 rad/s, on straight lines over rows of 333 Hz: a sample that repeats is six rows."""
    t = np.arange(0.0, 40.0, 0.003)
    sampled = np.arange(0.0, 40.1, 1 / 48)
    slow = 700.0 + 30.0 * np.sin(0.9 * sampled[:, None] + np.arange(3)) + [0.0, 80.0, 310.0]
    slow += 2.0 * np.random.default_rng(5).standard_normal(slow.shape)
    coarse = 9.0 * np.round(slow / 9.0)
    rotors = np.stack([np.interp(t, sampled, c) for c in coarse.T], axis=1)
    columns = {f"rotor_{k}": rotors[:, k] for k in range(3)}
    air = np.ones(len(t), dtype=bool)
    assert dead_columns(Flight(pd.DataFrame({"t": t} | columns)), air) == []
    rotors[(t > 10.0) & (t < 12.0), 1] = 805.0
    (dead,) = dead_columns(Flight(pd.DataFrame({"t": t} | columns | {"rotor_1": rotors[:, 1]})), air)
    assert dead.column == "rotor_1"
    assert dead.rows[(t > 10.1) & (t < 11.9)].all()
    assert not dead.rows[(t < 9.9) | (t > 12.1)].any()


def test_motor_columns_that_never_turn_behind_the_last_motor_are_no_dead_sensors():
    flight = changed(measured(24), rotor_4=0.0, rotor_5=0.0)
    assert "dead_column" not in {f.code for f in examine(flight).findings}


def test_single_wrong_samples_are_spikes_and_no_wraps():
    flight = measured(25)
    x = flight.get("vx")[:, 0].copy()
    x[700:702], x[1100:1102] = 40.0, -40.0
    codes = {f.code for f in examine(changed(flight, vx=x)).findings}
    assert "spikes" in codes
    assert not codes & {"wrapped", "sign_flips"}


def test_an_angle_that_wraps_keeps_its_values():
    t = np.arange(0, 20, 0.01)
    angle = 0.9 * t + 0.2 * np.sin(t) + 1e-3 * np.random.default_rng(1).standard_normal(len(t))
    flight = Flight(simulated(7).table.iloc[: len(t)].assign(tilt_0=np.mod(angle + np.pi, 2 * np.pi) - np.pi))
    result = examine(flight)
    assert "2 pi" in found(result, "wrapped").what
    assert not empty(cleaned(flight, result), ["tilt_0"]).any()


def test_a_held_flight_is_compared_as_the_one_with_its_true_samples(flown):
    holding, true = flown
    model = Model(load_vehicle(QUADROTOR))
    used = cleaned(holding, examine(holding, model.vehicle))
    pd.testing.assert_frame_equal(used.table, true.table)
    error, raw = (equation_error(model, f) for f in (used, holding))
    thin = Flight(holding.table[::5].reset_index(drop=True))
    expected = equation_error(model, thin)
    rms = [np.sqrt(np.nanmean(np.square(e.residual), axis=0)) for e in (error, expected, raw)]
    # the thinned flight lacks four of five commands, which shows in thrust and torque alone
    np.testing.assert_allclose(rms[0][:2], rms[1][:2], rtol=0.01)
    assert (rms[0] < 1.02 * rms[1]).all()
    assert (rms[0][3:] < 0.95 * rms[2][3:]).all()
    assert error.scored.sum() == pytest.approx(expected.scored.sum(), rel=0.02)


@pytest.mark.long
def test_steps_of_a_held_flight_lead_from_sample_to_sample(flown):
    holding, true = flown
    model = Model(load_vehicle(QUADROTOR))
    thin = Flight(holding.table[::5].reset_index(drop=True))
    one, expected = (rollouts(model, f, parse_horizons("1,0.1s")) for f in (true, thin))
    assert one.starts.tolist() == pytest.approx(expected.starts.tolist(), abs=3)
    for horizon in ("1", "0.1s"):
        errors = [mean_errors([r])["position"][horizon] for r in (one, expected)]
        assert errors[0] == pytest.approx(errors[1], rel=0.03)


def test_streams_of_different_phases_have_rollouts(flown):
    flight = Flight(fast_flyer.fly(QUADROTOR, 6.0, 3))
    apart = held(held(flight, [*P, *Q], 5), V, 4, phase=1)
    used = cleaned(apart, examine(apart))
    result = rollouts(Model(load_vehicle(QUADROTOR)), used, parse_horizons("0.1s"))
    assert result.starts[0] > 150
    assert mean_errors([result])["position"]["0.1s"] < 0.005


def test_what_was_derived_from_held_samples_is_derived_anew():
    full = simulated(8, rate_hz=200.0, duration=12.0, noise=0.0)
    flight = held(full, P, 5)
    stairs = derive.velocity(flight.t, flight.get(*P), 0.1)
    flight = Flight(flight.table.assign(**dict(zip(V, stairs.T, strict=True))), {"derived": list(V)})
    used = cleaned(flight, examine(flight))
    known = ~empty(used, V)[:, 0]
    assert known[flight.t > 3].mean() == pytest.approx(0.2, abs=0.01)
    wrong = np.abs(flight.get(*V) - full.get(*V))[known].max()
    assert np.abs(used.get(*V) - full.get(*V))[known][1:-1].max() < 0.05 < wrong


def test_an_accepted_finding_leaves_its_cells():
    flight = stands(measured(26), "rotor_1", 7.0, 13.0, 0.0)
    result = examine(flight)
    taken = [_accepted(f) if f.code == "dead_column" else f for f in result.findings]
    assert empty(cleaned(flight, result), ["rotor_1"]).any()
    assert not empty(cleaned(flight, replace(result, findings=taken)), ["rotor_1"]).any()


def _accepted(finding):
    taken = replace(finding)
    object.__setattr__(taken, "accepted", True)
    return taken


def resting(seconds=20.0, **columns):
    rng = np.random.default_rng(4)
    t = np.arange(0, seconds, 0.01)
    n = len(t)
    table = {"t": t} | {c: 0.005 * rng.standard_normal(n) for c in W}
    table |= {c: g + 0.03 * rng.standard_normal(n) for c, g in zip(A, (0.2, -0.1, 9.8), strict=True)}
    return Flight(pd.DataFrame(table).assign(**columns))


@pytest.mark.parametrize(
    "columns",
    [
        {},
        dict.fromkeys(MOTORS, 150.0),
        dict.fromkeys(MOTORS, 0.0),
        {"airborne": 0.0},
        {"px": 0.0, "py": 0.0, "pz": 0.1},
    ],
)
def test_a_vehicle_that_stands_all_the_time_does_not_fly(columns):
    result = examine(resting(**columns))
    assert found(result, "no_flight").severity == "reject"
    assert result.airborne_seconds == 0


def test_a_flag_that_never_says_so_is_believed_unless_motors_and_height_say_the_opposite():
    flight = simulated(7, duration=12.0)
    result = examine(changed(flight, airborne=0.0))
    assert found(result, "airborne_flag").severity == "warning"
    assert "they are believed" in found(result, "airborne_flag").what
    assert result.airborne_seconds == pytest.approx(airborne_rows(flight).seconds(flight.t))
    imu = Flight(flight.table[["t", *W, *A, *MOTORS]].assign(airborne=0.0))
    # An estimator that settles on the ground climbs, too.
    climbs = resting(airborne=0.0, px=0.0, py=0.0, pz=np.minimum(0.3 * np.maximum(np.arange(2000) * 0.01 - 8.0, 0), 1))
    assert "no_flight" in {f.code for f in examine(climbs).findings}
    assert "no_flight" in {f.code for f in examine(imu).findings}


def test_a_flag_that_always_says_so_is_not_believed_while_the_motors_are_off():
    result = examine(resting(airborne=1.0, **dict.fromkeys(MOTORS, 0.0)))
    assert {"no_flight", "airborne_flag"} <= {f.code for f in result.findings}


def test_a_few_rows_before_a_gap_are_no_rest():
    flight = simulated(7, duration=14.0)
    table = flight.table[(flight.t > 8.0) & ((flight.t < 8.03) | (flight.t > 9.5))]
    assert airborne_rows(Flight(table.reset_index(drop=True))).rows.all()


def test_a_hover_without_noise_still_flies():
    t = np.arange(0, 10, 0.01)
    hover = pd.DataFrame({"t": t} | dict.fromkeys((*W, "ax", "ay"), 0.0) | {"az": 9.81} | dict.fromkeys(MOTORS, 500.0))
    assert airborne_rows(Flight(hover)).rows.all()


def test_commands_that_change_between_two_rows_change_once():
    vehicle = load_vehicle(QUADROTOR)
    rng = np.random.default_rng(0)
    t, fine = np.arange(0, 20, 0.01), np.arange(0, 20, 1e-4)
    times, values = np.arange(0.003, 20, 0.1), 600 + 30 * rng.standard_normal((200, 4))
    latest = np.clip(np.searchsorted(times, fine, side="right") - 1, 0, None)
    row = np.minimum((fine / 0.01 + 1e-9).astype(int), len(t) - 1)
    mean = {f"cmd_rotor_{k}": np.bincount(row, values[latest, k]) / np.bincount(row) for k in range(4)}
    steps = premises._steps(Flight(pd.DataFrame({"t": t} | mean)), np.ones(len(t), dtype=bool), vehicle)
    assert steps["commanded rotors"] == pytest.approx(0.1)


def test_coarse_rotor_speeds_keep_every_sample():
    flight = rounded(measured(27), [f"rotor_{k}" for k in range(4)], 1.0)
    assert not empty(cleaned(flight, examine(flight)), [f"rotor_{k}" for k in range(4)]).any()


def test_a_command_that_was_never_logged_is_left_out_and_nothing_is_predicted_there():
    flight = simulated(3, "quadrotor", duration=15.0)
    lost = flight.t > 8.0
    table = flight.table.copy()
    table.loc[lost, "cmd_rotor_2"] = 0.0
    spoiled = Flight(table, {})
    check = examine(spoiled)
    (finding,) = [f for f in check.findings if f.code == "dead_column"]
    assert (finding.severity, finding.channels) == ("warning", ("cmd_rotor_2",))
    assert np.isnan(cleaned(spoiled, check).get("cmd_rotor_2")[lost, 0]).mean() > 0.95
    assert np.isfinite(cleaned(spoiled, check).get("cmd_rotor_1")).all()
    assert not [f for f in examine(flight).findings if f.code == "dead_column"]


def flown_with(rotors):
    """A flight whose rotors' commands are `rotors` (number: value) from 3.0 to 3.8 s, and these rows."""
    table = fast_flyer.fly(QUADROTOR, 8.0, 6)
    lost = ((table["t"] >= 3.0) & (table["t"] < 3.8)).to_numpy()
    for k, value in rotors.items():
        table.loc[lost, f"cmd_rotor_{k}"] = value
    return Flight(table), lost


def test_a_rotor_that_a_mixer_without_room_cuts_off_is_commanded_so():
    """A command of zero is lost where the others go on as ever, and true where one of them is full meanwhile."""
    vehicle = load_vehicle(QUADROTOR)

    def dead(rotors):
        check = examine(flown_with(rotors)[0], vehicle)
        return {c for f in check.findings if f.code == "dead_column" for c in f.channels}

    full = 1.01 * flown_with({})[0].get(*MOTORS).max()
    assert dead({2: 0.0}) == {"cmd_rotor_2"}
    assert dead({2: 0.0, 0: full}) == set()
    # Full all along, as one that stands still, or for a moment, is no reason.
    same = flown_with({2: 0.0})[0]
    same.table["cmd_rotor_0"] = full
    assert "dead_column" in [f.code for f in examine(same, vehicle).findings]
    brief, lost = flown_with({2: 0.0})
    brief.table.loc[np.flatnonzero(lost)[:20], "cmd_rotor_0"] = full
    assert "dead_column" in [f.code for f in examine(brief, vehicle).findings]


def test_nothing_is_predicted_where_one_rotor_has_had_no_command_for_long():
    flight, lost = flown_with({2: np.nan})
    covered = Model(load_vehicle(QUADROTOR)).predict(flight).covered
    stale = lost & (flight.t > 3.0 + 0.3)
    assert not covered[stale].any()
    assert covered[~lost & (flight.t < 7.9)].mean() > 0.98


def test_a_rotor_whose_commands_begin_late_predicts_nothing_before_and_one_that_stays_is_written_once():
    flight, _ = flown_with({})
    late, still = flight.table.copy(), flight.table.copy()
    late.loc[late["t"] < 3.0, "cmd_rotor_2"] = np.nan
    still["cmd_rotor_2"] = 500.0
    still.loc[still.index % 200 > 0, "cmd_rotor_2"] = np.nan
    model = Model(load_vehicle(QUADROTOR))
    covered = model.predict(Flight(late)).covered
    assert not covered[flight.t < 2.7].any()
    assert covered[(flight.t > 3.1) & (flight.t < 6.9)].all()
    assert model.predict(Flight(still)).covered[(flight.t > 1.0) & (flight.t < 6.9)].all()
