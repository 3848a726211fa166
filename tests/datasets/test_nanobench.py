"""NanoBench files become flight tables with the units that the files hold."""

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.datasets import location, nanobench
from infotraj.errors import InputError
from infotraj.evaluation.lateral_force import lateral_force

RNG = np.random.default_rng(1)


def as_logged(t, position, attitude, throttle, battery=3.8):
    """A NanoBench file of a flight: (n, 3) m, (n, 4) scalar first, (n, 4) share of full scale."""
    log = pd.DataFrame({"t": 1.7e9 + t})
    for k, axis in enumerate("xyz"):
        log[f"p{axis}"] = position[:, k]
        log[f"v{axis}"] = np.gradient(position[:, k], t)
        log[f"sp_ctrltarget_{axis}"] = position[:, k]
        log[f"w{axis}_vicon"] = 0.1 * (k + 1)
        log[f"imu_acc_{axis}"] = 1.0 * (axis == "z")
    for k, name in enumerate(("qw", "qx", "qy", "qz")):
        log[name] = attitude[:, k]
    for k in range(4):
        log[f"motor_motor_m{k + 1}"] = throttle[:, k] * 65535
    log["sp_ctrltarget_yaw"] = 0.3
    log["pwr_pm_vbat"] = battery
    return log


def hover(seconds=10.0):
    t = np.arange(0, seconds, 0.01)
    position = np.tile([0.0, 0.0, 1.0], (len(t), 1))
    throttle = 0.8 + 0.02 * RNG.standard_normal((len(t), 4))
    return t, position, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1)), throttle


@pytest.fixture
def without_variable(monkeypatch):
    monkeypatch.delenv(location.VARIABLE, raising=False)


def test_reads_units_and_frames(tmp_path):
    t, position, attitude, throttle = hover()
    as_logged(t, position, attitude, throttle).to_csv(tmp_path / "a.csv", index=False)
    flight = nanobench.read(tmp_path / "a.csv")
    assert flight.t[0] == 0
    np.testing.assert_allclose(flight.get("wx", "wy", "wz")[5], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(flight.get("ax", "ay", "az")[5], [0, 0, 9.80665])
    np.testing.assert_allclose(flight.numbered("cmd_rotor_"), throttle, atol=1e-9)
    np.testing.assert_allclose(rotations.to_euler(flight.get("ref_qw", "ref_qx", "ref_qy", "ref_qz"))[7], [0, 0, 0.3])


def test_extrapolated_commands_are_not_data(tmp_path):
    t, position, attitude, throttle = hover()
    throttle[600:] = throttle[600] + np.arange(len(t) - 600)[:, None] * np.array([0.01, -0.02, 0.03, 0.01])
    throttle[100:110] = throttle[100] + np.arange(10)[:, None] * 0.001  # a few lost packets, interpolated: kept
    as_logged(t, position, attitude, throttle).to_parquet(tmp_path / "a.parquet")
    lost = np.isnan(nanobench.read(tmp_path / "a.parquet").numbered("cmd_rotor_")).all(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(lost), np.arange(600, len(t)))


def test_identical_files_count_once(tmp_path):
    t, position, attitude, throttle = hover()
    log = as_logged(t, position, attitude, throttle)
    for name in ("B1_fast_rep1", "B1_fast_rep2", "B7_oval_slow_rep1"):
        log.to_csv(tmp_path / f"{name}.csv", index=False)
    as_logged(t, position + 1, attitude, throttle).to_csv(tmp_path / "B1_fast_rep3.csv", index=False)
    assert list(nanobench.files(tmp_path)) == ["B1_fast_rep1", "B1_fast_rep3"]
    assert nanobench.speed("B9_trefoil_fast_rep1") == "fast"
    assert nanobench.speed("B6_linear_ramp_rep2") == ""


@pytest.mark.parametrize("content", ["t,px\n0,1\n1,2\n", "", "not a table"])
def test_other_files_are_refused_in_one_line(tmp_path, content):
    path = tmp_path / "a.csv"
    path.write_text(content)
    with pytest.raises(InputError) as error:
        nanobench.read(path)
    assert "a.csv" in str(error.value)
    assert "\n" not in str(error.value)


def test_the_variable_wins_over_the_config(tmp_path, monkeypatch):
    for root in ("one", "two"):
        (tmp_path / root / "nanobench").mkdir(parents=True)
    monkeypatch.setenv(location.VARIABLE, str(tmp_path / "one"))
    assert location.dataset("nanobench", tmp_path / "two") == tmp_path / "one" / "nanobench"
    monkeypatch.delenv(location.VARIABLE)
    assert location.dataset("nanobench", tmp_path / "two") == tmp_path / "two" / "nanobench"


@pytest.mark.usefixtures("without_variable")
def test_absent_data_name_the_command_that_gets_them(tmp_path):
    assert location.find_dataset("nanobench", tmp_path) is None
    with pytest.raises(InputError, match="infotraj data get nanobench"):
        location.dataset("nanobench", tmp_path)
    assert "infotraj data get nanobench" in location.how_to_get("nanobench")


def test_real_flights_have_the_crazyflies_drag():
    folder = location.find_dataset("nanobench")
    if folder is None:
        pytest.skip(location.how_to_get("nanobench"))
    good = nanobench.good_flights(folder)
    assert "B9_trefoil_fast_rep10" not in good
    assert sum(nanobench.speed(name) == "fast" for name in good) == 8
    flown = lateral_force(nanobench.read(good["B9_trefoil_fast_rep4"]))
    drag = [np.polyfit(flown.velocity[:, k], flown.force[:, k], 1)[0] for k in range(2)]
    # A rotor drag of 0.2 to 0.6 1/s is what is known of vehicles of this size; its sign must oppose the motion.
    assert all(-0.6 < value < -0.2 for value in drag)
