"""Faults of recording: each is found where it is, and costs no more of the log than it must."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from check_flights import A, P, Q, V, W, _with, simulated

from infotraj.checking import check, check_logs, examine
from infotraj.checking.airborne import airborne_rows
from infotraj.checking.codes import known
from infotraj.checking.outliers import impossible_commands
from infotraj.errors import UsageError
from infotraj.flight import Flight
from infotraj.vehicle import load_vehicle, parse_vehicle

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
QUADROTOR = load_vehicle(VEHICLES / "quadrotor.yaml")
FLIGHT = simulated(7, duration=20.0)
T = FLIGHT.t


def found(log, code):
    (finding,) = [f for f in examine(log).findings if f.code == code]
    return finding


def changed(rows, **values):
    table = FLIGHT.table.copy()
    for name, value in values.items():
        table.loc[rows, name] = value
    return Flight(table)


def spans_cover(finding, start, stop, slack=0.03):
    return abs(finding.spans[0][0] - start) < slack and abs(finding.spans[-1][1] - stop) < slack


def test_rows_on_the_ground_are_told_from_those_in_the_air():
    air = airborne_rows(FLIGHT)
    assert not air.rows[T < 1.9].any()
    assert air.rows[T > 4].all()
    assert air.ground == pytest.approx(0.1, abs=0.01)
    assert airborne_rows(Flight(FLIGHT.table.assign(airborne=(T > 10) * 1.0))).rows.sum() == (T > 10).sum()
    by_height = airborne_rows(Flight(FLIGHT.table.drop(columns=[f"cmd_rotor_{k}" for k in range(4)])))
    assert (by_height.rows == air.rows).mean() > 0.98


def test_a_stream_that_is_extrapolated_to_the_end_is_cut_where_it_died():
    late = T >= 12
    line = {n: FLIGHT.get(n)[late, 0][0] + (0.5 + 0.1 * k) * (T[late] - 12) for k, n in enumerate(A)}
    check_ = examine(changed(late, **line))
    finding = next(f for f in check_.findings if f.code == "dead_stream")
    assert finding.severity == "cut"
    assert spans_cover(finding, 12, T[-1])
    assert set(finding.channels) == set(A)
    assert check_.usable == [(0.0, pytest.approx(12, abs=0.03))]


def test_smooth_commands_of_a_controller_without_noise_are_no_straight_lines():
    """From row to row they bend by less than single precision rounds; over half a second they do."""
    smooth = {f"cmd_rotor_{k}": 2000.0 + 40.0 * np.sin(0.9 * T + k) for k in range(4)}
    check_ = examine(Flight(FLIGHT.table.assign(**smooth), dict(FLIGHT.meta)))
    assert not [f for f in check_.findings if f.code == "dead_stream"]


def test_a_short_bridge_is_noted_and_left_out():
    bridged = (T >= 9) & (T <= 10)
    line = {n: np.linspace(FLIGHT.get(n)[bridged, 0][0], FLIGHT.get(n)[bridged, 0][-1] + 0.3, bridged.sum()) for n in A}
    check_ = examine(changed(bridged, **line))
    finding = next(f for f in check_.findings if f.code == "dead_stream")
    assert check_.outcome == "passed"
    assert finding.drop
    assert len(check_.usable) == 2


def test_a_stuck_gyro_is_found_and_a_vehicle_at_rest_is_not():
    stuck = (T >= 8) & (T <= 13)
    finding = found(changed(stuck, **dict(zip(W, (0.1, -0.2, 0.3), strict=True))), "stuck")
    assert finding.severity == "cut"
    assert spans_cover(finding, 8, 13)
    assert not [f for f in check(FLIGHT) if f.code in ("stuck", "dead_stream")]


def test_spikes_are_found_at_their_times():
    rows = [600, 900, 1300]
    finding = found(changed(rows, wy=[8.0, -9.0, 8.0]), "spikes")
    assert finding.severity == "note"
    np.testing.assert_allclose([a for a, _ in finding.spans], T[rows])
    assert finding.values["counts"] == {"wy": 3}


def test_a_clipped_gyro_is_saturated():
    clipped = FLIGHT.table.assign(wx=np.clip(FLIGHT.table["wx"], -0.12, 0.12))
    assert found(Flight(clipped), "saturated").severity == "warning"


def test_impossible_commands_are_found():
    with_throttle = FLIGHT.table.assign(**{f"cmd_rotor_{k}": FLIGHT.table[f"cmd_rotor_{k}"] / 1500 for k in range(4)})
    with_throttle.loc[1000:1100, "cmd_rotor_1"] = -3.0
    finding = found(Flight(with_throttle), "impossible_command")
    assert finding.severity == "warning"
    assert spans_cover(finding, T[1000], T[1100])


ROTOR = {"position": [0.1, 0.1, 0.0], "spin": 1, "moment_constant": 0.01}


@pytest.mark.parametrize(
    ("rotor", "top"),
    [
        ({"input": "throttle", "thrust_polynomial": [0.0, 0.0, 8.0]}, 1.0),
        ({"input": "speed", "thrust_coefficient": 1e-6, "max_speed": 2000.0}, 2000.0),
        ({"input": "thrust", "thrust_coefficient": 1e-6, "max_speed": 2000.0}, 4.0),
        (None, 1.0),  # no vehicle: what stays below 1 is a throttle
    ],
)
def test_a_command_is_impossible_beyond_what_its_input_can_be_and_not_before(rotor, top):
    rotors = [{"name": f"rotor_{k}", **ROTOR, **rotor} for k in range(4)] if rotor else []
    vehicle = parse_vehicle({"name": "quad", "mass": 1.0, "rotors": rotors}) if rotor else None
    for size, expected in ((0.0, 0), (1.0, 0), (1.05, 101), (-0.05, 101)):
        if size < 0 and rotor and rotor["input"] == "speed":
            expected = 0  # a speed's sign says which way the rotor turns
        table = FLIGHT.table.assign(**{f"cmd_rotor_{k}": 0.5 * top for k in range(4)})
        table.loc[1000:1100, "cmd_rotor_2"] = size * top
        findings = impossible_commands(Flight(table), np.ones(len(table), dtype=bool), vehicle)
        assert round(sum(f.values["share_of_flight"] for f in findings) * len(table)) == expected, size


def test_a_jump_of_the_pose_is_found():
    finding = found(_with(FLIGHT, P, FLIGHT.get(*P) + np.where(T > 11, 1.0, 0.0)[:, None]), "pose_jump")
    assert finding.spans[0][0] == pytest.approx(11, abs=0.02)


def test_an_estimator_that_diverges_is_cut_off():
    away = np.clip(T - 13, 0, None)[:, None] ** 2 * [0.5, -0.4, 0.1]
    finding = found(_with(FLIGHT, V, FLIGHT.get(*V) + 3 * away), "contradiction")
    assert finding.severity == "cut"
    assert finding.spans[0][0] == pytest.approx(13.5, abs=1.1)
    assert finding.spans[-1][1] > T[-1] - 1.6


def test_gaps_are_counted_and_not_bridged():
    keep = ~((T > 8) & (T < 8.5)) & ~((T > 12) & (T < 12.2))
    finding = found(Flight(FLIGHT.table[keep].reset_index(drop=True)), "gaps")
    assert finding.values["count"] == 2
    assert finding.values["seconds"] == pytest.approx(0.7, abs=0.05)


def test_time_that_runs_back_repeats_or_is_no_number_is_found_in_a_raw_table():
    table = FLIGHT.table.copy()
    assert found(table.assign(t=np.where(T > 10, T - 3, T)), "time_backwards").severity == "reject"
    table.loc[500, "t"] = table.loc[499, "t"]
    assert found(table, "duplicate_times").values["count"] == 1
    table.loc[700, "t"] = np.nan
    assert found(table, "time_not_finite").severity == "note"


def test_a_quaternion_of_another_length():
    for length in (2.0, 1.05):
        assert found(_with(FLIGHT, Q, length * FLIGHT.get(*Q)), "attitude_norm").severity == "reject"
    few = changed(range(300, 310), **dict.fromkeys(Q, 0.0))
    assert found(few, "attitude_norm").severity == "note"


def test_no_flight_and_low_flight():
    off = FLIGHT.table.assign(**{f"cmd_rotor_{k}": 0.0 for k in range(4)})
    assert found(Flight(off), "no_flight").severity == "reject"
    low = FLIGHT.table.assign(pz=0.1 + 0.1 * (FLIGHT.table["pz"] - 0.1))
    assert found(Flight(low), "low_flight").severity == "warning"


def test_a_reference_that_is_not_followed():
    reference = Flight(FLIGHT.table.assign(ref_px=0.0, ref_py=0.0, ref_pz=5.0))
    assert found(reference, "reference_not_followed").severity == "warning"


def test_what_cannot_be_answered_is_said():
    imu_only = Flight(FLIGHT.table.drop(columns=[*P, *Q, *V]))
    finding = found(imu_only, "cannot_answer")
    assert "rollouts" in finding.what
    assert "ground_effect" in finding.what
    missing = finding.values["missing"]
    assert any("px..pz" in m for m in missing["rollouts (open-loop prediction from a recorded state)"])
    nothing = Flight(FLIGHT.table[["t", "cmd_rotor_0"]])
    assert found(nothing, "nothing_measured").severity == "reject"


@pytest.mark.parametrize(
    ("lost", "says"),
    [
        ("qw", "attitude incomplete: qx, qy, qz hold numbers, qw not"),
        ("pz", "position incomplete: px, py hold numbers, pz not"),
        ("wx", "angular velocity incomplete: wy, wz hold numbers, wx not"),
        (
            "cmd_rotor_1",
            "rotor commands incomplete: cmd_rotor_0, cmd_rotor_2, cmd_rotor_3 hold numbers, cmd_rotor_1 not",
        ),
    ],
)
def test_half_a_channel_is_a_warning_in_a_table_and_in_its_file(tmp_path, lost, says):
    FLIGHT.write(tmp_path / "whole.csv")
    half = Flight(FLIGHT.table.drop(columns=[lost]))
    half.write(tmp_path / "half.csv")
    empty = Flight(FLIGHT.table.assign(**{lost: np.nan}))
    results = [examine(half), examine(empty), *check_logs([tmp_path / "half.csv", tmp_path / "whole.csv"])]
    said = [[f.what for f in r.findings if f.code == "incomplete"] for r in results]
    assert said == [[says], [says], [says], []]
    assert found(half, "incomplete").severity == "warning"


def test_a_flight_with_fewer_inputs_than_the_vehicle_is_most_likely_of_another_one():
    omav = load_vehicle(VEHICLES / "omav.yaml")
    four = {f.code: f for f in examine(FLIGHT, omav).findings}["missing_columns"]
    assert four.severity == "reject"
    assert four.what == "omav has 12 rotors, the flight commands of 4: another vehicle's file?"
    lost = Flight(FLIGHT.table.drop(columns=["cmd_rotor_1"]))
    hole = {f.code: f for f in examine(lost, QUADROTOR).findings}["missing_columns"]
    assert hole.what == "quadrotor has 4 rotors, the flight commands of 3, without cmd_rotor_1"
    none = Flight(FLIGHT.table.drop(columns=[f"cmd_rotor_{k}" for k in range(4)]))
    for flight, vehicle in ((FLIGHT, QUADROTOR), (none, QUADROTOR), (FLIGHT, None)):
        assert "missing_columns" not in {f.code for f in examine(flight, vehicle).findings}
    with pytest.raises(UsageError, match="missing_columns cannot be accepted; expected inputs of all rotors"):
        known(["missing_columns"])


def test_coverage_is_what_was_flown():
    covered = examine(FLIGHT).coverage
    rows = airborne_rows(FLIGHT).rows
    assert covered["wx"]["rms"] == pytest.approx(FLIGHT.get("wx")[rows, 0].std(), rel=1e-6)
    assert covered["tilt"]["q99"] < 1.0
    sine = Flight(pd.DataFrame({"t": T, "wx": np.sin(2 * np.pi * 1.5 * T), "wy": 0.0, "wz": 0.0}))
    assert examine(sine).coverage["wx"]["frequency_90"] == pytest.approx(1.5, abs=0.1)


@pytest.mark.parametrize("seed", range(12))
def test_no_table_is_too_strange(seed):
    rng = np.random.default_rng([13, seed])
    n = int(rng.choice([2, 3, 15, 80, 400]))
    names = list(rng.permutation([*P, *Q, *V, *W, *A, "cmd_rotor_0", "battery", "cmd_fx", "cmd_fy", "cmd_fz"]))
    columns = {"t": np.cumsum(rng.choice([0.01, 0.01, 0.01, 5.0], n))}
    for name in names[: int(rng.integers(1, len(names)))]:
        kind = rng.integers(6)
        x = rng.standard_normal(n) * rng.choice([1e-9, 1.0, 1e6])
        columns[name] = [x, np.zeros(n), np.full(n, np.nan), np.where(rng.random(n) < 0.9, np.nan, x), np.ones(n), x][
            kind
        ]
    result = examine(pd.DataFrame(columns))
    assert result.outcome in ("passed", "warning", "cut", "rejected")


def quadrotor_in(unit):
    """The flight with the rotor speeds that carry 2 kg on four rotors of 5e-6 N s^2/rad^2, in the given unit."""
    rotor = {"axis": [0, 0, 1], "thrust_coefficient": 5e-6, "moment_constant": 0.01}
    places = ([0.2, 0.2, 0], [-0.2, 0.2, 0], [-0.2, -0.2, 0], [0.2, -0.2, 0])
    rotors = [{"name": f"r{k}", "position": p, "spin": (-1) ** k, **rotor} for k, p in enumerate(places)]
    vehicle = parse_vehicle({"name": "quad", "mass": 2.0, "rotors": rotors})
    speed = np.sqrt(2.0 * np.clip(FLIGHT.get("az")[:, 0], 0, None) / 4 / 5e-6) * np.where(T < 1.9, 0.1, 1.0)
    return Flight(FLIGHT.table.assign(**{f"cmd_rotor_{k}": unit * speed for k in range(4)})), vehicle


@pytest.mark.parametrize(("unit", "codes"), [(1.0, set()), (60 / (2 * np.pi), {"rotor_unit"})])
def test_rotor_speeds_in_rpm_carry_too_much(unit, codes):
    flight, vehicle = quadrotor_in(unit)
    assert {f.code for f in check(flight, vehicle) if f.severity == "reject"} == codes
