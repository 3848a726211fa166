"""Whole flights: closed loop with a simple controller, tables, repeatability and failures."""

import numpy as np
import pytest

from infotraj import rotations
from infotraj.dynamics.actuators import body_wrench
from infotraj.errors import InfotrajError, InputError
from infotraj.robots.plant.plant import Plant
from infotraj.robots.plant.sensors import Noise
from infotraj.robots.plant.truth import Truth, load_truth
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")
PLANT_A = load_truth("config/plants/omav_a.yaml", OMAV)
TRUE_POSE = ["px", "py", "pz"], ["qw", "qx", "qy", "qz"]


def pitching(duration=2.0, amplitude=0.6):
    t = np.arange(0, duration, 0.01)
    zero = np.zeros((len(t), 3))
    w, y = 2 * np.pi / duration, np.array([0.0, 1.0, 0.0])
    pitch = 0.5 * amplitude * (1 - np.cos(w * t))
    return Reference(
        t, zero + np.array([0.3, -0.2, 1.0]), rotations.from_euler(0 * t, pitch, 0 * t), zero,
        0.5 * amplitude * w * np.sin(w * t)[:, None] * y, zero, 0.5 * amplitude * w * w * np.cos(w * t)[:, None] * y,
    )  # fmt: skip


class PdController:
    """PD with feedforward and the pseudo-inverse of the wrench matrix, written apart from the library's."""

    period = 0.01

    def __init__(self, reference, gain=1.0, period=0.01):
        self.reference, self.gain, self.period = reference, gain, period
        tilts = np.eye(6) * np.pi / 2
        columns = []
        for i, rotor in enumerate(OMAV.rotors):
            speed = np.eye(12)[i] / np.sqrt(7.2e-6)
            columns += [body_wrench(OMAV, speed, np.zeros(6)), body_wrench(OMAV, speed, tilts[rotor.tilt])]
        self.inverse = np.linalg.pinv(np.stack(columns, axis=1))
        self.samples = []

    def reset(self):
        self.samples = []

    def command(self, k, estimate):
        self.samples.append(k)
        r = self.reference
        turn = rotations.log(rotations.multiply(rotations.conjugate(estimate.attitude), r.attitude[k]))
        force = 9 * (r.position[k] - estimate.position) + 4.5 * (r.velocity[k] - estimate.velocity)
        force = 4.04 * (r.acceleration[k] + [0, 0, 9.81] + self.gain * force)
        angular = r.angular_acceleration[k] + self.gain * (60 * turn + 12 * (r.rate[k] - estimate.rate))
        wrench = np.concatenate([rotations.to_body(estimate.attitude, force), OMAV.inertia_matrix() @ angular])
        cosine, sine = (self.inverse @ wrench).reshape(12, 2).T
        tilt = np.arctan2(sine[:6] + sine[6:], cosine[:6] + cosine[6:])
        both = np.tile(tilt, 2)
        thrust = np.maximum(cosine * np.cos(both) + sine * np.sin(both), 0.0)
        return wrench, np.sqrt(thrust / 7.2e-6), tilt


def flown(truth=PLANT_A, seed=1, reference=None, gain=1.0, **options):
    reference = reference or pitching()
    controller = PdController(reference, gain)
    options.setdefault("settle", 2.0)
    flight, true = Plant(OMAV, truth, **options).fly_with_truth(reference, controller, np.random.default_rng(seed))
    return flight, true, controller


@pytest.fixture(scope="module")
def flight_a():
    return flown()


def test_without_hidden_effects_the_reference_is_tracked_to_the_sensors_noise():
    # A PD loop lags by its actuators' 20 ms: 0.24 rad/s x 0.02 s x g / 9 s^-2 = 5 mm.
    flight, true, _ = flown(Truth.ideal(OMAV), reference=pitching(8.0))
    reference = flight.get("ref_px", "ref_py", "ref_pz"), flight.get("ref_qw", "ref_qx", "ref_qy", "ref_qz")
    assert np.linalg.norm(true[TRUE_POSE[0]].to_numpy() - reference[0], axis=1).max() < 8e-3
    assert rotations.angle_between(true[TRUE_POSE[1]].to_numpy(), reference[1]).max() < np.radians(0.5)


def test_hidden_effects_show_and_keep_flying(flight_a):
    flight, true, _ = flight_a
    attitude = flight.get("ref_qw", "ref_qx", "ref_qy", "ref_qz")
    away = rotations.angle_between(true[TRUE_POSE[1]].to_numpy(), attitude)
    assert np.radians(1.0) < away.max() < np.radians(15.0)


def test_the_table_is_what_the_files_page_says(flight_a):
    flight, _, controller = flight_a
    rows = np.arange(len(flight.t))
    assert len(rows) == 400
    np.testing.assert_allclose(flight.t, rows * 0.005, atol=1e-12)
    pose = flight.get("px", "py", "pz", "qw", "qx", "qy", "qz")
    assert np.isfinite(pose[::2]).all()
    assert np.isnan(pose[1::2]).all()
    estimate = [f"est_{c}" for c in ("px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")]
    assert np.isfinite(flight.get("wx", "wy", "wz", "ax", "ay", "az", *estimate)).all()
    held = flight.table[[c for c in flight.table if c.startswith("cmd_")]].to_numpy()
    assert held.shape[1] == 6 + 12 + 6
    np.testing.assert_array_equal(held[::2], held[1::2])
    assert np.abs(np.diff(held[::2], axis=0)).max() > 0
    reference = flight.get("ref_qw", "ref_qx", "ref_qy", "ref_qz")
    np.testing.assert_allclose(reference[::2], controller.reference.attitude, atol=1e-12)
    # Two seconds of settling at k = 0, then each sample once.
    assert controller.samples == [0] * 200 + list(range(200))


def test_nothing_of_the_truth_is_in_the_flight(flight_a):
    flight, true, _ = flight_a
    assert not {"rotor_0", "tilt_0", "thrust_0", "vx", "fx"} & set(flight.table)
    assert flight.meta["vehicle"] == "omav"
    assert "10 ms" in flight.meta["estimator"]
    numbers = {str(x) for x in (PLANT_A.mass, *PLANT_A.center_of_mass, *PLANT_A.servos.zero_error)}
    assert not any(number in str(flight.meta) for number in numbers)
    assert not np.array_equal(flight.get("wx", "wy", "wz"), true[["wx", "wy", "wz"]].to_numpy())


def test_sensor_noise_has_the_stated_size(flight_a):
    flight, true, _ = flight_a
    gyro = flight.get("wx", "wy", "wz") - true[["wx", "wy", "wz"]].to_numpy()
    force = flight.get("ax", "ay", "az") - true[["ax", "ay", "az"]].to_numpy()
    place = (flight.get("px", "py", "pz") - true[TRUE_POSE[0]].to_numpy())[::2]
    turn = rotations.multiply(rotations.conjugate(true[TRUE_POSE[1]].to_numpy()), flight.get("qw", "qx", "qy", "qz"))[
        ::2
    ]
    for found, size in ((gyro, 0.01), (force, 0.1), (place, 1e-3), (rotations.log(turn), np.radians(0.1))):
        assert found.std() == pytest.approx(size, rel=0.12)
        assert abs(found.mean()) < 5 * size / np.sqrt(found.size)


def test_commands_act_from_their_own_row_on(flight_a):
    flight, true, _ = flight_a
    command, speed = flight.table["cmd_rotor_3"].to_numpy(), true["rotor_3"].to_numpy()
    for k in range(0, 398, 2):
        up = command[k] > speed[k]
        expected = command[k] + (speed[k] - command[k]) * np.exp(-0.005 / (0.0125 if up else 0.025))
        assert speed[k + 1] == pytest.approx(expected, rel=1e-9)


def test_a_seed_gives_one_flight_and_another_seed_another():
    short = pitching(0.5)
    first, again, other = (flown(seed=s, reference=short, settle=0.2)[0] for s in (5, 5, 6))
    assert first.table.equals(again.table)
    assert not np.array_equal(first.get("wx"), other.get("wx"))


def test_half_the_time_step_gives_the_same_flight():
    quiet = Noise(0.0, 0.0, 0.0, 0.0)
    places, turns, torques = [], [], []
    for timestep in (1e-3, 5e-4):
        _, true, _ = flown(timestep=timestep, noise=quiet)
        places.append(true[TRUE_POSE[0]].to_numpy())
        turns.append(true[TRUE_POSE[1]].to_numpy())
        torques.append(true[["tx", "ty", "tz"]].to_numpy())
    # Well below the sensors' noise (1 mm, 0.1 deg) and the smallest part of the residual (0.06 N m).
    assert np.linalg.norm(places[0] - places[1], axis=1).max() < 5e-4
    assert rotations.angle_between(turns[0], turns[1]).max() < np.radians(0.03)
    assert np.sqrt(np.mean((torques[0] - torques[1]) ** 2)) < 0.01


def test_a_diverging_loop_is_one_line():
    for gain, match in ((-3.0, "from its reference, turning at"), (np.nan, "not finite")):
        with pytest.raises(InfotrajError, match=match) as failure:
            flown(gain=gain, reference=pitching(8.0))
        assert "\n" not in str(failure.value)


def test_a_diverging_simulation_is_one_line(tmp_path, monkeypatch):
    plant = Plant.load(OMAV, "config/plants/omav_a.yaml")
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log to where it runs
    plant.reset(np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(12), np.zeros(6))
    plant.bodies.qvel[0] = 1e12
    plant.advance(2)
    with pytest.raises(InfotrajError, match="diverged before t") as failure:
        plant.bodies.check(0.01)
    assert "\n" not in str(failure.value)


def test_other_periods_are_refused():
    plant, reference = Plant(OMAV, PLANT_A), pitching(0.5)
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match=r"controller's period of 0\.02 s"):
        plant.fly(reference, PdController(reference, period=0.02), rng)
    coarse = Reference(*(getattr(reference, f)[::2] for f in reference.__dataclass_fields__))
    with pytest.raises(InputError, match=r"sample time of 0\.02 s"):
        plant.fly(coarse, PdController(coarse), rng)
    with pytest.raises(InputError, match="time step"):
        Plant(OMAV, PLANT_A, timestep=3e-3)
