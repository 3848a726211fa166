"""Recordings: what was logged can be read back, equal flights give equal hashes, missing channels are left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.dynamics.actuators import rotor_frames, thrusts
from infotraj.dynamics.allocation import Allocation
from infotraj.errors import InputError
from infotraj.flight import COMMANDED_TORQUE, Flight
from infotraj.recording import content_hash, read_back, record_flight
from infotraj.residual.learning_data import learning_data
from infotraj.vehicle import Vehicle, load_vehicle, parse_vehicle

OMAV = Path(__file__).parents[2] / "config" / "vehicles" / "omav.yaml"
HIDDEN_TORQUE = np.array([0.2, -0.1, 0.05])  # N m, added to every commanded torque


@pytest.fixture(scope="module")
def omav() -> Vehicle:
    return load_vehicle(OMAV)


def quadrotor() -> Vehicle:
    arms = [(0.1, 0.1, 1), (-0.1, 0.1, -1), (-0.1, -0.1, 1), (0.1, -0.1, -1)]
    rotors = [
        {
            "name": f"rotor_{i}",
            "position": [x, y, 0.0],
            "spin": spin,
            "input": "throttle",
            "thrust_polynomial": [0.0, 0.0, 8.0],
            "moment_constant": 0.01,
        }
        for i, (x, y, spin) in enumerate(arms)
    ]
    return parse_vehicle({"name": "quad", "rotors": rotors})


def figure_8(vehicle: Vehicle, duration: float = 6.0, rate: float = 200.0) -> Flight:
    """A figure-8 in attitude (26 deg) at a fixed place, flown 60 ms late, with a torque that no one commanded."""
    t = np.arange(0.0, duration, 1.0 / rate)

    def attitude(at: np.ndarray) -> np.ndarray:
        phase = 2 * np.pi * at / 6.0
        return rotations.from_euler(np.radians(26) * np.sin(phase), np.radians(26) * np.sin(2 * phase), 0 * at)

    def angular_rate(at: np.ndarray, h: float = 1e-4) -> np.ndarray:
        return rotations.log(rotations.multiply(rotations.conjugate(attitude(at - h)), attitude(at + h))) / (2 * h)

    flown = attitude(t - 0.06)
    w = angular_rate(t - 0.06)
    dw = (angular_rate(t - 0.059) - angular_rate(t - 0.061)) / 0.002
    inertia = vehicle.inertia_matrix()
    assert vehicle.mass is not None
    torque = dw @ inertia + np.cross(w, w @ inertia) - HIDDEN_TORQUE
    force = rotations.to_body(flown, [0.0, 0.0, vehicle.mass * vehicle.gravity])
    speeds, tilts = Allocation(vehicle).actuators(np.concatenate([force, torque], axis=1))
    wobble = 0.02 * np.stack([np.sin(3 * t), np.cos(2 * t), np.sin(t)], axis=1)
    columns = {"t": t}
    columns |= dict(zip(("px", "py", "pz"), (wobble + np.array([0, 0, 1.5])).T, strict=True))
    columns |= dict(zip(("qw", "qx", "qy", "qz"), flown.T, strict=True))
    columns |= dict(zip(("wx", "wy", "wz"), w.T, strict=True))
    columns |= dict(zip(("ax", "ay", "az"), (force / vehicle.mass).T, strict=True))
    columns |= dict(zip(("ref_px", "ref_py", "ref_pz"), (0 * wobble + np.array([0, 0, 1.5])).T, strict=True))
    columns |= dict(zip(("ref_qw", "ref_qx", "ref_qy", "ref_qz"), attitude(t).T, strict=True))
    columns |= dict(zip(("cmd_fx", "cmd_fy", "cmd_fz"), force.T, strict=True))
    columns |= dict(zip(COMMANDED_TORQUE, torque.T, strict=True))
    columns |= {f"cmd_rotor_{i}": speeds[:, i] for i in range(speeds.shape[1])}
    columns |= {f"cmd_tilt_{i}": tilts[:, i] for i in range(tilts.shape[1])}
    return Flight(pd.DataFrame(columns), {"scenario": "figure_8", "seed": 3})


class LinearResidual:
    """A residual that the tests can compute by hand: mean 2 x torque input, variance 0.01."""

    def mean(self, U: np.ndarray) -> np.ndarray:
        return 2.0 * U[:, 3:]

    def variance(self, U: np.ndarray) -> np.ndarray:
        return np.full((len(U), 3), 0.01)


@pytest.fixture(scope="module")
def flight(omav: Vehicle) -> Flight:
    return figure_8(omav)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, omav: Vehicle, flight: Flight) -> dict:
    path = tmp_path_factory.mktemp("recording") / "flight.rrd"
    record_flight(path, flight, omav, gp=LinearResidual())
    assert [p.name for p in path.parent.iterdir()] == ["flight.rrd"]
    return read_back(path)


def test_commands_come_back_as_flown(recorded: dict, flight: Flight) -> None:
    torque = recorded["torque/y/commanded"]
    expected = flight.table["cmd_ty"].to_numpy()[::2]
    np.testing.assert_allclose(torque["t"], flight.t[::2], atol=1e-8)
    np.testing.assert_allclose(torque["Scalars:scalars"], expected, atol=1e-12)


def test_pose_comes_back_as_flown(recorded: dict, flight: Flight) -> None:
    vehicle = recorded["world/vehicle"]
    assert np.diff(vehicle["t"]).min() > 1 / 50 - 1e-6
    np.testing.assert_allclose(vehicle["Transform3D:translation"], flight.get("px", "py", "pz")[::4], atol=1e-6)
    xyzw = vehicle["Transform3D:quaternion"]
    apart = rotations.angle_between(xyzw[:, [3, 0, 1, 2]], flight.get("qw", "qx", "qy", "qz")[::4])
    assert apart.max() < 1e-5


def test_arrows_are_the_thrusts_of_the_first_principles_model(recorded: dict, flight: Flight, omav: Vehicle) -> None:
    tilts, speeds = flight.numbered("cmd_tilt_")[::4], flight.numbered("cmd_rotor_")[::4]
    positions, axes = rotor_frames(omav, tilts)
    force = thrusts(omav, speeds)[..., None] * axes
    lengths = []
    for i, rotor in enumerate(omav.rotors):
        frame = recorded[f"world/vehicle/tilt_{rotor.tilt}"]["Transform3D:quaternion"][:, [3, 0, 1, 2]]
        arrow = recorded[f"world/vehicle/tilt_{rotor.tilt}/{rotor.name}/thrust"]
        vector = rotations.to_world(frame, arrow["Arrows3D:vectors"])
        foot = rotations.to_world(frame, arrow["Arrows3D:origins"])
        np.testing.assert_allclose(np.cross(vector, force[:, i]), 0.0, atol=1e-5)
        disc = foot + vector if rotor.coaxial == "lower" else foot
        np.testing.assert_allclose(disc, positions[:, i], atol=1e-6)
        lengths.append(np.linalg.norm(vector, axis=1) / np.linalg.norm(force[:, i], axis=1))
    assert np.ptp(lengths) < 1e-5 * np.mean(lengths)


def test_residual_shows_the_hidden_torque(recorded: dict) -> None:
    for axis, hidden in zip("xyz", HIDDEN_TORQUE, strict=True):
        seen = recorded[f"residual/{axis}/seen"]["Scalars:scalars"][20:-20]
        assert np.median(seen) == pytest.approx(hidden, abs=2e-3)


def test_angular_acceleration_error_is_the_residual_over_the_inertia(recorded: dict, omav: Vehicle) -> None:
    error = recorded["error/angular_acceleration/z"]["Scalars:scalars"]
    residual = recorded["residual/z/seen"]["Scalars:scalars"]
    np.testing.assert_allclose(error, residual / omav.inertia_matrix()[2, 2], rtol=1e-12)


def test_a_recorded_demand_is_what_the_error_is_against(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    table = flight.between(0.0, 2.0).table
    inertia = np.diag(omav.inertia_matrix())
    for k, axis in enumerate("xyz"):
        table[f"demand_alpha{axis}"] = (table[f"cmd_t{axis}"] + HIDDEN_TORQUE[k]) / inertia[k] - 0.5
    record_flight(tmp_path / "f.rrd", Flight(table), omav)
    for axis in "xyz":
        error = read_back(tmp_path / "f.rrd")[f"error/angular_acceleration/{axis}"]["Scalars:scalars"]
        assert np.median(error) == pytest.approx(0.5, abs=0.03)


def test_residual_along_learning_data_is_what_was_learned(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    data = learning_data(flight, omav, response_of_model=False)
    record_flight(tmp_path / "f.rrd", flight, omav, gp=LinearResidual(), data=data)
    recorded = read_back(tmp_path / "f.rrd")
    seen = recorded["residual/y/seen"]
    np.testing.assert_allclose(seen["Scalars:scalars"], data.outputs[::2, 1] * omav.inertia_matrix()[1, 1], rtol=1e-9)
    mean = recorded["residual/y/mean"]["Scalars:scalars"]
    np.testing.assert_allclose(mean, 2.0 * data.inputs[::2, 4] * omav.inertia_matrix()[1, 1], rtol=1e-9)


def test_band_is_two_sigma_in_newton_metres(recorded: dict, flight: Flight, omav: Vehicle) -> None:
    mean = recorded["residual/x/mean"]["Scalars:scalars"]
    np.testing.assert_allclose(mean, 2.0 * flight.table["cmd_tx"].to_numpy()[::2], rtol=1e-9)
    upper = recorded["residual/x/upper"]["Scalars:scalars"]
    np.testing.assert_allclose(upper - mean, 2 * 0.1 * omav.inertia_matrix()[0, 0], rtol=1e-9)


def test_attitude_error_is_the_lag(recorded: dict, flight: Flight) -> None:
    error = recorded["error/attitude/norm"]["Scalars:scalars"]
    apart = rotations.angle_between(
        flight.get("qw", "qx", "qy", "qz"), flight.get("ref_qw", "ref_qx", "ref_qy", "ref_qz")
    )
    np.testing.assert_allclose(error, np.degrees(apart)[::2], atol=1e-6)


def test_equal_flights_have_equal_hashes(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    short = flight.between(0.0, 1.0)
    record_flight(tmp_path / "a.rrd", short, omav)
    record_flight(tmp_path / "b.rrd", short, omav)
    changed = short.table.copy()
    changed.loc[0, "cmd_tx"] += 1e-3
    record_flight(tmp_path / "c.rrd", Flight(changed), omav)
    assert content_hash(tmp_path / "a.rrd") == content_hash(tmp_path / "b.rrd")
    assert content_hash(tmp_path / "a.rrd") != content_hash(tmp_path / "c.rrd")


def test_estimate_is_preferred_to_the_sensor(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    table = flight.between(0.0, 1.0).table
    for name in ("px", "py", "pz"):
        table[f"est_{name}"] = 7.0
    record_flight(tmp_path / "f.rrd", Flight(table), omav)
    assert np.all(read_back(tmp_path / "f.rrd")["world/vehicle"]["Transform3D:translation"] == 7.0)


def test_samples_that_are_missing_are_left_out(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    table = flight.between(0.0, 2.0).table
    table.loc[1::2, ["px", "py", "pz", "cmd_tx"]] = np.nan
    record_flight(tmp_path / "f.rrd", Flight(table), omav)
    recorded = read_back(tmp_path / "f.rrd")
    assert np.isfinite(recorded["torque/x/commanded"]["Scalars:scalars"]).all()
    assert len(recorded["torque/x/commanded"]["t"]) == len(table) // 2


def test_fixed_rotors_and_few_channels(tmp_path: Path) -> None:
    t = np.arange(0.0, 2.0, 0.01)
    table = pd.DataFrame({"t": t, "px": t, "py": 0 * t, "pz": 0 * t} | {f"rotor_{i}": 0.5 + 0 * t for i in range(4)})
    record_flight(tmp_path / "f.rrd", Flight(table), quadrotor())
    recorded = read_back(tmp_path / "f.rrd")
    assert "world/vehicle/rotor_2/thrust" in recorded
    assert not [e for e in recorded if e.startswith(("torque", "error", "residual", "world/reference"))]
    np.testing.assert_allclose(recorded["world/flown/path"]["LineStrips3D:strips"][0][-1], [t[-2], 0, 0], atol=1e-6)


def test_a_flight_of_nothing_but_time(tmp_path: Path) -> None:
    record_flight(tmp_path / "f.rrd", Flight(pd.DataFrame({"t": [0.0, 1.0]})), quadrotor())
    assert "world/vehicle/body" in read_back(tmp_path / "f.rrd")


def test_rollout_says_what_it_is(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    record_flight(tmp_path / "f.rrd", flight.between(0.0, 0.5), omav, rollout=True)
    assert "Simulated rollout" in str(read_back(tmp_path / "f.rrd")["about"]["TextDocument:text"])


def test_layout_travels_with_the_recording(tmp_path: Path, omav: Vehicle, flight: Flight) -> None:
    from rerun.chunk import RrdReader

    record_flight(tmp_path / "f.rrd", flight.between(0.0, 0.5), omav)
    assert len(RrdReader(str(tmp_path / "f.rrd")).blueprints()) == 1


def test_what_is_not_a_recording_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "f.rrd").write_text("no recording")
    with pytest.raises(InputError, match="cannot be read"):
        read_back(tmp_path / "f.rrd")
