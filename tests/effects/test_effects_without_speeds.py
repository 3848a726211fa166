"""The rotors' angular momentum where the file says nothing of their speeds: it goes with the root of the thrust."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from exact_simulation import fly

from infotraj.comparing.equation_error import AXES
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.effects import catalogue
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import parse_vehicle

CONTENT = yaml.safe_load((Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml").read_text())
K_F, INERTIA = 1.5e-6, 3e-5
NOISE = {"gyro": 0.002, "accelerometer": 0.03, "position": 0.001, "attitude": 0.0005, "velocity": 0.003}
Gyroscopic = catalogue()["gyroscopic"]


def vehicle(lag, **keys):
    """The quadrotor with this lag; keys: of every rotor, in place of its thrust_coefficient."""
    rotors = [{**r, "time_constant": lag} for r in CONTENT["rotors"]]
    if keys:
        unknown = ("thrust_coefficient", "max_speed")
        rotors = [{k: v for k, v in r.items() if k not in unknown} | keys for r in rotors]
    return {**CONTENT, "rotors": rotors}


def by_thrust(table):
    """The same flight as its thrusts are asked for, N, and nothing measured of the rotors."""
    asked = {f"cmd_rotor_{i}": K_F * table[f"cmd_rotor_{i}"] ** 2 for i in range(4)}
    return Flight(table.assign(**asked).drop(columns=[f"rotor_{i}" for i in range(4)]), {})


def test_it_is_the_same_momentum_by_speed_and_by_thrust():
    table = fly(vehicle(0.0), {"gyroscopic": {"rotor_inertia": INERTIA}}, seconds=3.0)
    speeds = Model(parse_vehicle(vehicle(0.0)), [Gyroscopic(rotor_inertia=INERTIA)]).predict(Flight(table, {}))
    thrusts = Model(parse_vehicle(vehicle(0.0, input="thrust")), [Gyroscopic(momentum=INERTIA / np.sqrt(K_F))]).predict(
        by_thrust(table)
    )
    assert np.allclose(thrusts.angular_acceleration_mean[:-1], speeds.angular_acceleration_mean[:-1], rtol=0, atol=1e-9)


@pytest.mark.long
def test_what_leads_the_yaw_of_a_vehicle_without_speeds_is_named():
    """A lag that the file leaves out, and rotors that push back as they are spun up: yaw has less of the lag."""
    true = vehicle(0.0)
    hidden = {"rotor_lag": {"extra_time_constant": 0.05}, "gyroscopic": {"rotor_inertia": INERTIA}}
    flights = [by_thrust(fly(true, hidden, seconds=6.0, seed=k, noise=NOISE)) for k in (1, 2, 3)]
    found = diagnose(Model(parse_vehicle(vehicle(0.0, input="thrust"))), flights)
    assert set(found.supported) == {"rotor_lag", "gyroscopic"}
    told = found.finding("gyroscopic")
    assert told.parameters["momentum"] == pytest.approx(INERTIA / np.sqrt(K_F), rel=0.1)
    assert found.after.rmse[AXES.index("tz")] < 0.5 * found.before.rmse[AXES.index("tz")]


def test_a_file_gives_one_of_its_forms():
    both = Gyroscopic(rotor_inertia=INERTIA, momentum=0.02)
    with pytest.raises(InputError, match="rotor_inertia and momentum"):
        Model(parse_vehicle(vehicle(0.0)), [both])
    flight = by_thrust(fly(vehicle(0.0), {}, seconds=1.0))
    without_speeds = Model(parse_vehicle(vehicle(0.0, input="thrust")), [Gyroscopic(rotor_inertia=INERTIA)])
    with pytest.raises(InputError, match="no rotor speed"):
        without_speeds.predict(flight)
