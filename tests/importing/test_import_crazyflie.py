"""Crazyflie micro-SD logs: signs and units of the firmware's variables, compressed quaternions, mixes, real logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from flights_made import made_flight
from writers_crazyflie import floats
from writers_crazyflie import micro_sd as written

from infotraj import rotations
from infotraj.datasets.location import find_dataset, how_to_get
from infotraj.importing import import_log
from infotraj.importing.crazyflie import decompressed

GOOD = made_flight(3.0)
EULER = rotations.to_euler(GOOD.get("qw", "qx", "qy", "qz"))
XYZW = GOOD.get("qx", "qy", "qz", "qw")
G = 9.80665


def micro_sd(path: Path, columns: dict[str, tuple[str, np.ndarray]]) -> Path:
    return written(path, GOOD.t, columns)


POSITION = floats("stateEstimate.", "x y z", GOOD.get("px", "py", "pz"))


def compress(q: np.ndarray) -> int:
    """The 32 bits of a quaternion x y z w by their definition: two bits, and thrice a sign with nine bits."""
    largest = int(np.argmax(np.abs(q)))
    q = q * np.sign(q[largest])
    bits = format(largest, "02b")
    for k in range(4):
        if k != largest:
            bits += ("1" if q[k] < 0 else "0") + format(round(abs(q[k]) * np.sqrt(2) * 511), "09b")
    return int(bits, 2)


def test_compressed_quaternions_are_within_a_step_of_the_true_ones() -> None:
    generator = np.random.default_rng(3)
    q = rotations.normalize(generator.standard_normal((2000, 4)))
    q = np.concatenate([q, np.eye(4), -np.eye(4), [[0.5, -0.5, 0.5, -0.5]]])
    found = decompressed(np.array([compress(row) for row in q], dtype=np.uint32))
    found[np.isnan(found).any(axis=1)] = [1, 0, 0, 0]  # x alone is all bits 0, which a log says before it knows better
    angle = rotations.angle_between(found[:, [3, 0, 1, 2]], q[:, [3, 0, 1, 2]])
    assert angle.max() < 2 * np.sqrt(3) * np.sqrt(0.5) / 511  # half a step in each of three, twice that as an angle
    assert np.isnan(decompressed(np.array([0], dtype=np.uint32))).all()


def test_attitude_from_a_compressed_quaternion(tmp_path: Path) -> None:
    packed = np.array([compress(row) for row in XYZW])
    packed[:7] = 0
    columns = {"stateEstimateZ.quat": ("I", packed), **POSITION}
    found = import_log(micro_sd(tmp_path / "log00", columns))
    assert found.meta["channels"]["attitude"]["stream"] == "compressed"
    q = found.get("qw", "qx", "qy", "qz")
    assert np.isnan(q[:7]).all()
    assert rotations.angle_between(q[7:], GOOD.get("qw", "qx", "qy", "qz")[7:]).max() < 0.005


@pytest.mark.parametrize("group", ["stateEstimate", "stabilizer"])
def test_the_firmwares_pitch_angle_is_turned_round(group: str, tmp_path: Path) -> None:
    angles = np.degrees(EULER) * [1, -1, 1]
    columns = {**POSITION, **floats(f"{group}.", "roll pitch yaw", angles)}
    found = import_log(micro_sd(tmp_path / "log00", columns))
    angle = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), GOOD.get("qw", "qx", "qy", "qz"))
    assert angle.max() < 1e-6


def test_roll_and_yaw_without_pitch_are_no_attitude(tmp_path: Path) -> None:
    columns = {**POSITION, **floats("stateEstimate.", "roll yaw", np.degrees(EULER[:, [0, 2]]))}
    found = import_log(micro_sd(tmp_path / "log00", columns))
    assert "attitude" not in found.meta["channels"]
    assert any("stateEstimate.pitch" in note for note in found.meta["notes"])


def test_quaternions_of_a_tracker_that_sends_none_give_way_to_angles(tmp_path: Path) -> None:
    zeros = floats("locSrv.", "qx qy qz qw", 0.0 * XYZW)
    columns = {**zeros, **floats("locSrv.", "x y z", GOOD.get("px", "py", "pz"))}
    alone = import_log(micro_sd(tmp_path / "log00", columns))
    assert "qw" not in alone.table
    found = import_log(micro_sd(tmp_path / "log01", {**columns, **floats("ctrlLee.", "rpyx rpyy rpyz", EULER)}))
    angle = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), GOOD.get("qw", "qx", "qy", "qz"))
    assert angle.max() < 1e-6


@pytest.mark.parametrize(
    ("names", "kind", "factor"),
    [
        ("gyro.x gyro.y gyro.z", "f", np.degrees(np.ones(3))),
        ("ctrlLee.omegax ctrlLee.omegay ctrlLee.omegaz", "f", np.ones(3)),
        ("controller.r_roll controller.r_pitch controller.r_yaw", "f", np.array([1, -1, 1])),
        ("stateEstimateZ.rateRoll stateEstimateZ.ratePitch stateEstimateZ.rateYaw", "h", np.array([1e3, -1e3, 1e3])),
    ],
)
def test_rates_of_every_group(names: str, kind: str, factor: np.ndarray, tmp_path: Path) -> None:
    values = GOOD.get("wx", "wy", "wz") * factor
    columns = {name: (kind, column) for name, column in zip(names.split(), values.T, strict=True)}
    found = import_log(micro_sd(tmp_path / "log00", {**POSITION, **columns}))
    np.testing.assert_allclose(found.get("wx", "wy", "wz"), GOOD.get("wx", "wy", "wz"), atol=6e-4)


def test_the_estimators_acceleration_is_world_without_gravity_and_compressed_with_it(tmp_path: Path) -> None:
    q = GOOD.get("qw", "qx", "qy", "qz")
    world = rotations.to_world(q, GOOD.get("ax", "ay", "az"))
    attitude = floats("stateEstimate.", "qx qy qz qw", XYZW)
    without = floats("stateEstimate.", "ax ay az", world / G - [0, 0, 1])
    found = import_log(micro_sd(tmp_path / "log00", {**POSITION, **attitude, **without}))
    np.testing.assert_allclose(found.get("ax", "ay", "az"), GOOD.get("ax", "ay", "az"), atol=1e-5)
    packed = {n: ("h", c) for n, (_, c) in floats("stateEstimateZ.", "ax ay az", world * 1000).items()}
    found = import_log(micro_sd(tmp_path / "log01", {**POSITION, **attitude, **packed}))
    np.testing.assert_allclose(found.get("ax", "ay", "az"), GOOD.get("ax", "ay", "az"), atol=1e-3)


def test_motors_by_the_firmwares_mix(tmp_path: Path) -> None:
    """A roll command to the right (+) drives the left motors, 3 and 4; a yaw command 1 and 3; limits are kept."""
    n = len(GOOD.t)
    commands = np.tile([32768.0, 0.0, 0.0, 0.0], (n, 1))
    commands[10, 1], commands[20, 2], commands[30, 3], commands[40] = 6000, 6000, 1000, [0.0, 20000, 0, 0]
    columns = {**POSITION, **floats("controller.cmd_", "thrust roll pitch yaw", commands)}
    found = import_log(micro_sd(tmp_path / "log00", columns)).numbered("cmd_rotor_")
    expected = {
        0: [32768] * 4,
        10: [29768, 29768, 35768, 35768],
        20: [35768, 29768, 29768, 35768],
        30: [33768, 31768, 33768, 31768],
        40: [0, 0, 10000, 10000],
    }
    for row, motors in expected.items():
        np.testing.assert_allclose(found[row], np.array(motors) / 65535, atol=1e-7)


def test_what_was_put_out_comes_before_what_was_asked_for(tmp_path: Path) -> None:
    n = len(GOOD.t)
    pwm = {f"pwm.m{k}_pwm": ("I", np.full(n, 1000 * k)) for k in (1, 2, 3, 4)}
    asked = {f"motor.m{k}": ("I", np.full(n, 500 * k)) for k in (1, 2, 3, 4)}
    uncapped = {f"motor.m{k}req": ("i", np.full(n, -500 * k)) for k in (1, 2, 3, 4)}
    volts = {"pm.vbatMV": ("H", np.full(n, 3812))}
    found = import_log(micro_sd(tmp_path / "log00", {**POSITION, **uncapped, **asked, **pwm, **volts}))
    np.testing.assert_allclose(found.numbered("cmd_rotor_")[0], np.arange(1, 5) * 1000 / 65535)
    np.testing.assert_allclose(found.get("battery"), 3.812)
    found = import_log(micro_sd(tmp_path / "log01", {**POSITION, **uncapped, **asked}))
    np.testing.assert_allclose(found.numbered("cmd_rotor_")[0], np.arange(1, 5) * 500 / 65535)
    assert "depending on the firmware" in "".join(found.meta["notes"])
    found = import_log(micro_sd(tmp_path / "log02", {**POSITION, **uncapped}))
    np.testing.assert_array_equal(found.numbered("cmd_rotor_"), 0.0)
    assert "before the compensation of the battery" in "".join(found.meta["notes"])


def test_what_a_table_holds_of_the_motors_is_said_and_not_what_a_later_stream_lacks(tmp_path: Path) -> None:
    """Of the mix only what it is: that the log has no stabilizer.thrust, for another mix, is of no use to anybody."""
    n = len(GOOD.t)
    mix = floats("controller.cmd_", "thrust roll pitch yaw", np.tile([32768.0, 0.0, 0.0, 0.0], (n, 1)))
    asked = import_log(micro_sd(tmp_path / "log00", {**POSITION, **mix})).meta["notes"]
    assert [note.split(", before")[0] for note in asked] == ["rotor_command: what was asked of the motors"]
    given = {f"pwm.m{k}_pwm": ("I", np.full(n, 1000 * k)) for k in (1, 2, 3, 4)}
    assert import_log(micro_sd(tmp_path / "log01", {**POSITION, **mix, **given})).meta["notes"] == []
    chosen = {"rotor_command": {"fields": list(given)}}
    assert import_log(micro_sd(tmp_path / "log03", {**POSITION, **mix, **given}), settings=chosen).meta["notes"] == []
    del given["pwm.m4_pwm"]
    half = import_log(micro_sd(tmp_path / "log02", {**POSITION, **mix, **given})).meta["notes"]
    assert [note.partition(" ")[2].split()[0] for note in half] == ["left", "what"]


@pytest.mark.parametrize("name", ["thrustSi", "thrustSI"])
def test_the_commanded_wrench(name: str, tmp_path: Path) -> None:
    n = len(GOOD.t)
    columns = {f"ctrlLee.{name}": ("f", np.full(n, 0.3)), f"ctrlLee.torque{'x'}": ("f", np.full(n, 1e-4))}
    columns |= {"ctrlLee.torquey": ("f", np.full(n, -2e-4)), "ctrlLee.torquez": ("f", np.full(n, 3e-4))}
    found = import_log(micro_sd(tmp_path / "log00", {**POSITION, **columns}))
    np.testing.assert_allclose(found.get("cmd_fx", "cmd_fy", "cmd_fz")[5], [0, 0, 0.3], rtol=1e-6)
    np.testing.assert_allclose(found.get("cmd_tx", "cmd_ty", "cmd_tz")[5], [1e-4, -2e-4, 3e-4], rtol=1e-6)


def _logs(dataset: str, pattern: str) -> list[Path]:
    folder = find_dataset(dataset)
    if folder is None:
        pytest.skip(how_to_get(dataset))
    return sorted(p for p in folder.glob(pattern) if p.is_file())


def test_every_crazypad_log_is_imported() -> None:
    for path in _logs("crazypad", "*_data/*/*"):
        found = import_log(path)
        commands = "pwm" if "motor_data" in str(path) else "mix"
        assert found.meta["channels"]["rotor_command"]["stream"] == commands, path
        assert ("battery" in found.table) == (commands == "pwm"), path
        assert ("wx" in found.table) == (commands == "mix"), path
        assert "qw" not in found.table, path
        assert 2500 < len(found.table) < 2700, path
        if path.parent.name == "normal_flight":
            flown = np.median(found.numbered("cmd_rotor_")[found.get("pz")[:, 0] > 0.4], axis=0)
            assert ((flown > 0.45) & (flown < 0.8)).all(), path
            assert flown[[0, 2]].min() > flown[[1, 3]].max(), path  # 1 and 3 turn alike, and this airframe yaws


def test_every_crazyswarm2_log_is_imported_and_its_attitude_explains_its_motion() -> None:
    for path in _logs("crazyswarm2", "logs/log*"):
        found = import_log(path)
        assert found.meta["channels"]["attitude"]["stream"] == "lee", path
        assert {"cmd_fz", "cmd_tx", "wx", "px", "vx"} <= set(found.table.columns), path
        assert 0.2 < np.median(found.get("cmd_fz")) < 0.6, path
        # thrust along the tilted axis accelerates the vehicle sideways: both agree in sign and size
        t, tilt = (
            found.t,
            rotations.to_world(found.get("qw", "qx", "qy", "qz"), np.tile([0.0, 0, 1], (len(found.t), 1))),
        )
        step = max(int(0.3 / np.median(np.diff(t))), 1)
        mean = np.stack([np.convolve(tilt[:, k], np.ones(step) / step, "valid") for k in (0, 1)], -1)[:-1]
        moved = (found.get("vx", "vy")[step:] - found.get("vx", "vy")[:-step]) / (t[step:] - t[:-step])[:, None]
        steady = np.abs((t[step:] - t[:-step]) - step * np.median(np.diff(t))) < 0.02
        axis = int(np.argmax(moved[steady].std(axis=0)))
        slope = np.polyfit(mean[steady, axis], moved[steady, axis], 1)[0]
        load = int(path.name.removeprefix("log")) >= 182  # a load on a cable swings, and pulls on its own
        assert (3.0 if load else 6.0) < slope < 13.0, (path, slope)
