import numpy as np
import pytest

from infotraj import rotations
from infotraj.experiment.corpus.exact_flyer import STEP, Air, fly_exactly
from infotraj.experiment.corpus.tasks import TASKS, path
from infotraj.experiment.corpus.vehicles import MASSES, made_vehicle

STILL = {"rotor_drag": 0.0, "body_drag": 0.0}


def flown(task="fast eight", mass=0.75, speed=3.0, rotor_drag=0.3, body_drag=0.02, wind=0.0):
    rng = np.random.default_rng(4)
    vehicle = made_vehicle(mass, rng)
    places, yaw = path(task, 8.0, 1.5, speed, rng)
    air = Air(rotor_drag, body_drag, np.tile([wind, 0.0, 0.0], (len(places), 1)))
    return fly_exactly(vehicle, places, yaw, air, 1000.0, rng), vehicle, places


def test_the_flight_obeys_kinematics_and_newton():
    flight, vehicle, _ = flown()
    t, air = flight.t[1:-1], slice(5200, 11000)
    p, v, q = flight.get("px", "py", "pz"), flight.get("vx", "vy", "vz"), flight.get("qw", "qx", "qy", "qz")
    slope = (p[2:] - p[:-2]) / (2 * STEP)
    assert np.abs(slope - v[1:-1])[air].max() < 1e-4
    turned = rotations.log(rotations.multiply(rotations.conjugate(q[:-2]), q[2:])) / (2 * STEP)
    assert np.abs(turned - flight.get("wx", "wy", "wz")[1:-1])[air].max() < 2e-3
    felt = rotations.to_body(q[1:-1], (v[2:] - v[:-2]) / (2 * STEP) + [0, 0, vehicle.gravity])
    assert np.abs(felt - flight.get("ax", "ay", "az")[1:-1])[air].max() < 2e-2
    assert t[-1] > 11.0


def test_rotors_follow_their_commands_with_the_declared_lag():
    flight, vehicle, _ = flown()
    speed, command = flight.get("rotor_0")[:, 0], flight.get("cmd_rotor_0")[:, 0]
    # a command acts from its row on, and is held for two steps
    step = speed[1:] - speed[:-1]
    expected = (command[:-1] - speed[:-1]) * -np.expm1(-STEP / vehicle.rotors[0].time_constant)
    assert np.abs(step - expected).max() < 1e-3 * np.abs(step).max()


@pytest.mark.parametrize("mass", MASSES)
def test_a_hover_carries_the_weight_whatever_the_size(mass):
    flight, vehicle, places = flown("hover", mass, **STILL)
    here = (flight.t > 8.0) & (flight.t < 11.0)
    thrust = sum(r.thrust_coefficient * flight.get(f"rotor_{k}")[:, 0] ** 2 for k, r in enumerate(vehicle.rotors))
    assert thrust[here].mean() == pytest.approx(vehicle.mass * vehicle.gravity, rel=5e-3)
    assert np.abs(flight.get("px", "py", "pz") - places)[here].max() < 0.05


@pytest.mark.parametrize("task", TASKS)
def test_every_task_is_followed(task):
    flight, _, places = flown(task, speed=1.5)
    assert np.linalg.norm(flight.get("px", "py", "pz") - places, axis=1).max() < 0.5


def test_drag_is_felt_across_the_thrust_and_against_the_wind():
    calm, _, _ = flown("hover", **STILL, wind=3.0)
    blown, _, _ = flown("hover", rotor_drag=0.3, body_drag=0.0, wind=3.0)
    here = (calm.t > 9.0) & (calm.t < 11.0)
    for flight, expected in ((calm, 0.0), (blown, 0.3 * 3.0)):
        q = flight.get("qw", "qx", "qy", "qz")[here]
        across = flight.get("ax", "ay", "az")[here].copy()
        across[:, 2] = 0.0
        # the wind along x pushes along x; the thrust leans against it
        assert rotations.to_world(q, across)[:, 0].mean() == pytest.approx(expected, abs=0.05)


def test_on_the_ground_an_accelerometer_reads_gravity():
    flight, vehicle, _ = flown()
    rest = flight.t < 1.9
    # idling rotors lift a little less than the whole weight
    assert np.abs(flight.get("vx", "vy", "vz")[rest]).max() < 0.02
    assert flight.get("az")[rest].mean() == pytest.approx(vehicle.gravity, abs=0.01)
