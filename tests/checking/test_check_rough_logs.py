"""True logs pass, however rough: estimators' slow errors, shaken and filtered IMUs, poor accelerometers."""

import shlex

import numpy as np
import pytest
from click.testing import CliRunner

from infotraj.checking import check_logs, examine
from infotraj.checking.command import check_command
from infotraj.experiment.corpus.injected_errors import INJECTED
from infotraj.experiment.corpus.kinematic_flights import simulated
from infotraj.experiment.rough.autopilot import autopilot
from infotraj.experiment.rough.nanodrone import nanodrone
from infotraj.flight import POSITION, VELOCITY, Flight
from infotraj.importing.command import import_command
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle("config/vehicles/quadrotor.yaml")


def clean(seed, duration=30.0):
    return simulated(seed, "quadrotor", duration=duration, noise=0.0)


def rejections(flight):
    return [(f.code, f.what) for f in examine(flight).findings if f.severity in ("reject", "cut")]


@pytest.mark.parametrize("seed", range(6))
def test_a_log_as_an_autopilot_writes_it_passes(seed):
    assert rejections(autopilot(clean(seed), VEHICLE, np.random.default_rng([1, seed]))) == []


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_a_nanodrones_log_with_a_poor_accelerometer_passes(seed):
    assert rejections(nanodrone(clean(seed), VEHICLE, np.random.default_rng([2, seed]))) == []


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "code"),
    [
        ("rates in deg/s", "rate_unit"),
        ("position in mm", "position_unit"),
        ("quaternion world to body", "attitude_inverse"),
    ],
)
def test_errors_are_found_in_rough_logs_too(kind, code):
    for seed in range(3):
        rng = np.random.default_rng([3, seed])
        wrong = INJECTED[kind].spoil(autopilot(clean(seed), VEHICLE, rng), VEHICLE, rng)
        (finding,) = [f for f in examine(wrong).findings if f.severity == "reject"]
        assert finding.code == code
        assert finding.remedy.startswith("infotraj import LOG --set ")


@pytest.mark.parametrize("times", [1000.0, 3.28084])
def test_position_and_velocity_in_the_same_wrong_unit_are_told_by_the_accelerometer(times):
    flight = simulated(1, "quadrotor", duration=15.0)
    columns = (*POSITION, *VELOCITY)
    found = examine(Flight(flight.table.assign(**{c: times * flight.table[c] for c in columns}))).findings
    assert {f.code for f in found if f.severity == "reject"} == {"position_unit", "velocity_unit"}


def test_a_still_vehicle_is_not_told_that_its_gyro_has_another_unit():
    flight = clean(1)
    rng = np.random.default_rng(4)
    n = len(flight.t)
    values = {
        **dict.fromkeys(("vx", "vy", "vz"), 0.0),
        **{c: np.median(flight.get(c)) + 1e-3 * rng.standard_normal(n) for c in POSITION},
        **dict(zip(("qw", "qx", "qy", "qz"), (1.0, 0.0, 0.0, 0.0), strict=True)),
        **{c: 0.05 * rng.standard_normal(n) for c in ("wx", "wy", "wz")},
        **{c: (9.81 if c == "az" else 0.0) + 0.2 * rng.standard_normal(n) for c in ("ax", "ay", "az")},
        "airborne": 1.0,
    }
    found = examine(Flight(flight.table.assign(**values))).findings
    assert not [f.code for f in found if f.code.startswith(("rate_", "velocity_", "position_", "acceleration_"))]


@pytest.mark.long
def test_logs_of_one_mapping_get_one_answer(tmp_path):
    """Two gentle flights hardly tell body rates from world rates; a third one of the same mapping does."""
    paths = []
    for seed in range(3):
        flight = simulated(20 + seed, "omav", duration=20.0)
        if seed:
            # nearly level, nearly no heading: the two frames agree
            flight = gentle(flight)
        wrong = INJECTED["rates in the world frame"].spoil(flight, VEHICLE, np.random.default_rng(seed))
        paths.append(tmp_path / f"{seed}.parquet")
        Flight(wrong.table, {"mapping": "mine", "mapping_sha256": "1"}).write(paths[-1])
    alone = [check_logs([p])[0].outcome for p in paths]
    assert alone[0] == "rejected"
    assert "passed" in alone[1:]
    assert [c.outcome for c in check_logs(paths)] == ["rejected"] * 3


@pytest.mark.long
def test_one_log_that_is_grossly_wrong_stays_rejected_beside_good_ones(tmp_path):
    paths = [tmp_path / f"{seed}.parquet" for seed in range(3)]
    for seed, path in enumerate(paths):
        flight = simulated(30 + seed, "quadrotor", duration=15.0)
        if seed == 2:
            flight = INJECTED["rates in deg/s"].spoil(flight, VEHICLE, np.random.default_rng(0))
        Flight(flight.table, {"mapping": "mine", "mapping_sha256": "1"}).write(path)
    assert [c.outcome for c in check_logs(paths)] == ["passed", "passed", "rejected"]


def gentle(flight):
    """The same flight with attitude and rates a hundredth as large."""
    from infotraj import rotations

    q = rotations.exp(0.01 * rotations.log(rotations.normalize(flight.get("qw", "qx", "qy", "qz"))))
    rates = np.gradient(rotations.log(q), flight.t, axis=0) + 1e-3 * np.random.default_rng(0).standard_normal(
        (len(q), 3)
    )
    columns = dict(zip(("qw", "qx", "qy", "qz", "wx", "wy", "wz"), np.hstack([q, rates]).T, strict=True))
    table = flight.table.assign(**columns).drop(columns=["ax", "ay", "az"])
    return Flight(table.assign(ax=np.nan, ay=np.nan, az=np.nan), dict(flight.meta))


def test_a_remedy_is_a_command_that_can_be_given_as_it_stands(tmp_path):
    """What check says to do is done word by word; the log that comes out passes."""
    log, new = tmp_path / "my log.csv", tmp_path / "NEW.parquet"
    flight = INJECTED["rates in FRD"].spoil(simulated(5, "quadrotor", duration=15.0), VEHICLE, np.random.default_rng(0))
    Flight(flight.table, {}).write(log)
    said = CliRunner().invoke(check_command, [str(log)]).stdout
    (line,) = [x for x in said.splitlines() if " do: " in x]
    fix, _, setting = line.partition("do: ")[2].partition(", or --accept")[0].partition(" (or ")
    words = shlex.split(fix)
    assert words == ["infotraj", "import", str(log), "--fix", "-o", "NEW.parquet"]
    assert shlex.split(setting.rstrip(")")) == ["--set", "rate.axes=[x,-y,-z]"]
    done = CliRunner().invoke(import_command, [str(new) if w == "NEW.parquet" else w for w in words[2:]])
    assert done.exit_code == 0, done.output
    assert check_logs([new])[0].outcome == "passed"
