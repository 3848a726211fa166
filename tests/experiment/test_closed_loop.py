"""The controller with named effects: it inverts what the model says, and the flight gets better for it."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hidden_flights import OMAV, truth

from infotraj.control.tracking import TrackingController, no_residual
from infotraj.effects.registry import effect_class
from infotraj.errors import InputError
from infotraj.evaluation.pose_error import pose_error
from infotraj.experiment.closed_loop.summary import ratio_of_means
from infotraj.experiment.common.config import ExperimentConfig
from infotraj.models import Model, load_model
from infotraj.models.instant import Instant
from infotraj.robots.plant.plant import Plant
from infotraj.robots.robot import Estimate
from infotraj.trajectories.wandering import wandering

OFFSET = [0.012, -0.008, 0.01]


def effect(name, **values):
    return effect_class(name)(**values)


INVERTIBLE = {
    "mass_offset": effect("mass_offset", dm=0.3),
    "inertia_error": effect("inertia_error", dxx=0.012, dyy=-0.01, dzz=0.02),
    "com_offset": effect("com_offset", r=OFFSET),
    "thrust_scale": effect("thrust_scale", factor=0.85),
    "rotor_effectiveness": effect("rotor_effectiveness", rotor=5, factor=0.7),
    "coaxial_loss": effect("coaxial_loss", fraction=0.15),
    "moment_scale": effect("moment_scale", factor=0.5),
    "axial_inflow": effect("axial_inflow", k=2e-4),
    "ground_effect": effect("ground_effect", k=0.3),
    "battery_sag": effect("battery_sag", rate=0.005),
    "rotor_interference": effect("rotor_interference", k=0.08),
    "servo_bias": effect("servo_bias", bias=[0.02, -0.02, 0.01, 0.015, -0.01, 0.02]),
    "rotor_drag": effect("rotor_drag", k=1e-4),
    "linear_drag": effect("linear_drag", d=[0.5, 0.5, 0.8]),
    "quadratic_drag": effect("quadratic_drag", d=[0.3, 0.3, 0.4]),
    "angular_damping": effect("angular_damping", d=[0.06, 0.06, 0.08]),
    "gyroscopic": effect("gyroscopic", rotor_inertia=3e-5),
    "steady_force": effect("steady_force", f=[1.0, -0.5, 1.5]),
    "steady_torque": effect("steady_torque", t=[0.1, -0.2, 0.05]),
    "hub_moment": effect("hub_moment", k=1.7e-6),
    "translational_lift": effect("translational_lift", k=0.02),
    "thrust_exponent": effect("thrust_exponent", n=2.3),
}
BESIDE = {
    "wind": effect("wind", v=[3.0, -2.0, 0.5]),
    "pressure_centre": effect("pressure_centre", r=[0.05, -0.04, 0.03]),
}


@pytest.fixture(scope="module")
def reference():
    return wandering(6.0, 0.8, 0.4, np.random.default_rng(1))


@pytest.mark.parametrize("name", INVERTIBLE)
def test_the_command_makes_the_model_do_what_is_demanded(name, reference):
    model = Instant(Model(OMAV, [INVERTIBLE[name]]))
    assert model.left_out == ()
    k = 300
    estimate = Estimate(
        reference.position[k] + 0.02,
        reference.attitude[k],
        reference.velocity[k] + [0.1, -0.2, 0.1],
        reference.rate[k] + 0.1,
    )
    state = np.concatenate([estimate.position, estimate.attitude, estimate.velocity, estimate.rate])
    with_effect = TrackingController(OMAV, reference, response=model)
    for _ in range(3):
        _, rotor, tilt = with_effect.command(k, estimate)
    demand = with_effect.record().to_numpy()[k, 1:]
    inertia, rate = OMAV.inertia_matrix(), estimate.rate
    asked = demand.copy()
    asked[3:] -= np.cross(rate, inertia @ rate) / np.diag(inertia)
    done = model.accelerations(reference.t[k], state, rotor, tilt)
    np.testing.assert_allclose(done, asked, atol=5e-3)
    plain = TrackingController(OMAV, reference)
    _, rotor, tilt = plain.command(k, estimate)
    missed = np.abs(model.accelerations(reference.t[k], state, rotor, tilt) - asked).max()
    if name not in (
        "moment_scale",
        "gyroscopic",
        "hub_moment",
        "ground_effect",
    ):  # vanish in equal pairs, and far from the ground
        assert missed > 1e-2, "the effect changes nothing here: the test would prove nothing"


def test_an_instant_is_the_prediction_of_a_vehicle_at_rest_in_its_commands(reference):
    """Along a constant command the settled prediction of the whole flight and the instant's agree."""
    from infotraj.flight import Flight

    count = 200
    rotor, tilt = np.full(12, 600.0), np.array([0.1, -0.1, 0.2, 0.0, -0.2, 0.1])
    t = 0.005 * np.arange(count)
    columns = {"t": t, "px": 0 * t, "py": 0 * t, "pz": 0 * t + 1.0, "qw": 0 * t + 1.0, "qx": 0 * t, "qy": 0 * t}
    columns |= {"qz": 0 * t, "vx": 0 * t + 0.7, "vy": 0 * t - 0.3, "vz": 0 * t + 0.2}
    columns |= {"wx": 0 * t + 0.4, "wy": 0 * t - 0.2, "wz": 0 * t + 0.3, "ax": 0 * t, "ay": 0 * t, "az": 0 * t + 9.81}
    columns |= {f"cmd_rotor_{i}": 0 * t + rotor[i] for i in range(12)}
    columns |= {f"cmd_tilt_{i}": 0 * t + tilt[i] for i in range(6)}
    kinds = [e for n, e in (INVERTIBLE | BESIDE).items() if n not in ("battery_sag", "moment_scale")]
    model = Model(OMAV, kinds)
    predicted = model.predict(Flight(pd.DataFrame(columns), {}))
    state = np.array([0, 0, 1.0, 1, 0, 0, 0, 0.7, -0.3, 0.2, 0.4, -0.2, 0.3])
    found = Instant(model).accelerations(0.5, state, rotor, tilt)
    np.testing.assert_allclose(found[:3], predicted.specific_force[100], atol=1e-9)
    np.testing.assert_allclose(found[3:], predicted.angular_acceleration[100], atol=1e-9)


def test_without_effects_the_command_is_that_of_the_first_principles_model(reference):
    estimate = Estimate(*(np.asarray(x) for x in ([0.1, 0, 1.4], [1.0, 0, 0, 0], [0, 0.1, 0], [0.2, 0.1, -0.3])))
    plain = TrackingController(OMAV, reference, no_residual()).command(10, estimate)
    same = TrackingController(OMAV, reference, response=Instant(Model(OMAV))).command(10, estimate)
    # Rotors of one arm share its tilt, so the allocation meets a wrench to 0.2 mN m only; the response sees that.
    np.testing.assert_allclose(plain[0], same[0], atol=5e-4)
    np.testing.assert_allclose(plain[2], same[2], atol=1e-3)


def test_the_effect_in_the_controller_takes_off_half_of_the_error_at_least(reference):
    hidden = truth(center_of_mass=tuple(OFFSET))

    def error(plant, *effects):
        controller = TrackingController(OMAV, reference, response=Instant(Model(OMAV, effects)))
        return pose_error(Plant(OMAV, plant, settle=5.0).fly(reference, controller, np.random.default_rng(3)), OMAV)

    absent, present = error(hidden), error(hidden, effect("com_offset", r=OFFSET))
    wrong = error(hidden, effect("steady_torque", t=[0.3, 0.4, 0.0]))
    assert present.attitude < 0.5 * absent.attitude
    assert present.rotors < 0.5 * absent.rotors + 0.5 * error(truth()).rotors
    assert wrong.attitude > 0.5 * absent.attitude


@pytest.mark.parametrize("name", BESIDE)
def test_what_the_air_does_to_others_is_inverted_with_them(name, reference):
    drag = INVERTIBLE["quadratic_drag"]
    state = np.concatenate([reference.position[9], reference.attitude[9], [2.0, -1.0, 0.5], [0.1, -0.2, 0.3]])
    with_it, without = (
        Instant(Model(OMAV, effects)).accelerations(0.0, state, np.full(12, 700.0), np.zeros(6))
        for effects in ([drag, BESIDE[name]], [drag])
    )
    assert np.abs(with_it - without).max() > 0.1
    assert Instant(Model(OMAV, [drag, BESIDE[name]])).left_out == ()


@pytest.mark.parametrize(
    "name", ["rotor_lag", "servo_lag", "actuation_delay", "servo_backlash", "gyro_bias", "sensor_lag"]
)
def test_what_cannot_be_inverted_at_once_is_named(name):
    values = {"gyro_bias": {"b": [0.1, 0, 0]}, "actuation_delay": {"delay": 0.02}}
    values |= {"servo_backlash": {"half_width": 0.01}, "sensor_lag": {"time_constant": 0.01}}
    made = effect(name, **values.get(name, {"extra_time_constant": 0.03}))
    assert Instant(Model(OMAV, [made])).left_out == (name,)


def test_a_hanging_load_is_refused():
    with pytest.raises(InputError, match="suspended_load in a controller"):
        Instant(Model(OMAV, [effect("suspended_load", mass=0.3, length=0.5)]))


def test_the_oracle_of_each_case_is_what_its_truth_hides():
    chosen = ExperimentConfig().closed_loop
    for case in chosen.cases:
        hidden = yaml.safe_load(Path(chosen.folder, case, "truth.yaml").read_text())
        found = {e.name: e for e in load_model(f"{chosen.folder}/{case}/oracle.yaml").effects}
        offset = found["com_offset"].r if "com_offset" in found else np.zeros(3)
        np.testing.assert_allclose(hidden["center_of_mass"], offset)
        drag = found["linear_drag"].d if "linear_drag" in found else np.zeros(3)
        np.testing.assert_allclose(hidden.get("air", {}).get("linear_drag", [0, 0, 0]), drag)
        factor = np.ones(12)
        if "rotor_effectiveness" in found:
            factor[found["rotor_effectiveness"].rotor] = found["rotor_effectiveness"].factor
        np.testing.assert_allclose(hidden["rotors"]["thrust_factor"], factor)


def test_the_share_removed_is_paired():
    cost = np.array([1.0, 4.0, 2.0, 8.0])
    share, low, high = ratio_of_means(0.75 * cost, cost)
    assert share == low == high == pytest.approx(0.75)
