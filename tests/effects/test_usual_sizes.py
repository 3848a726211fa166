"""What a usual size of an effect does to a vehicle, and between which bounds its numbers are physical."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj.effects import effect_class
from infotraj.effects.actuators import coarse, still_tilts
from infotraj.effects.channels import missing_channel
from infotraj.effects.rigid_body import arm_length
from infotraj.effects.sensor_place import SensorPlace
from infotraj.effects.thrust import arms, cancelling
from infotraj.flight import Flight
from infotraj.vehicle import load_vehicle

VEHICLES = Path(__file__).parents[2] / "config/vehicles"
QUAD, OMAV = (load_vehicle(VEHICLES / f"{n}.yaml") for n in ("quadrotor", "omav"))
WEIGHT = QUAD.mass * QUAD.gravity
ARM = float(np.mean([np.linalg.norm(r.position) for r in QUAD.rotors]))
SPEED = np.sqrt(WEIGHT / 4 / QUAD.rotors[0].thrust_coefficient)  # rad/s in hover
RATIO = QUAD.rotors[0].moment_constant  # m: reaction torque over thrust
MOMENTS = np.diag(QUAD.inertia_matrix())


def scale(name, place=0, vehicle=QUAD):
    cls = effect_class(name)
    return cls.scale(vehicle, [p for p in cls.parameters if not p.index][place])


def bounds(name, place=0, vehicle=QUAD):
    cls = effect_class(name)
    return cls.bounds(vehicle, [p for p in cls.parameters if not p.index][place])


@pytest.mark.parametrize(
    ("name", "does", "usual"),
    [
        # A deceleration (m/s^2) at 1 m/s.
        ("rotor_drag", lambda k: k * 4 * SPEED / QUAD.mass, 0.15),
        ("linear_drag", lambda d: d / QUAD.mass, 0.15),
        ("quadratic_drag", lambda d: d / QUAD.mass, 0.07),
        ("axial_inflow", lambda k: k * 4 * SPEED / QUAD.mass, 0.4),
        # Thrust over the mass that is carried, at 1 m/s.
        ("translational_lift", lambda k: 4 * k / QUAD.mass, 0.02),
        # Shares of the weight, of an arm, of both, of the file's own numbers.
        ("steady_force", lambda f: f / WEIGHT, 0.03),
        ("steady_torque", lambda t: t / (WEIGHT * ARM), 0.01),
        ("com_offset", lambda r: r / ARM, 0.03),
        ("pressure_centre", lambda r: r / ARM, 0.1),
        ("mass_offset", lambda m: m / QUAD.mass, 0.05),
        ("inertia_error", lambda j: j / MOMENTS[0], 0.15),
        # A rate that decays by this share a second, about the axis of the least inertia.
        ("angular_damping", lambda d: d / MOMENTS.min(), 0.8),
        # The fourth power of the radius, from a rotor of 0.1 m.
        ("hub_moment", lambda k: k / 1e-6 / (QUAD.rotors[0].radius / 0.1) ** 4, 1.0),
        # Seconds by which the reaction leads: of a momentum k sqrt(T) the change is k / (2 sqrt(T)) times that of T.
        ("gyroscopic", lambda _: scale("gyroscopic", 1) / (2 * np.sqrt(WEIGHT / 4) * RATIO), 0.1),
    ],
)  # fmt: skip
def test_a_usual_size_does_what_is_usual(name, does, usual):
    assert np.max(does(scale(name))) == pytest.approx(usual)


def test_bounds_are_what_a_body_may_have():
    assert bounds("mass_offset") == pytest.approx((-0.5 * QUAD.mass, 3.0 * QUAD.mass))
    for i, moment in enumerate(MOMENTS):
        assert bounds("inertia_error", i) == pytest.approx((-0.8 * moment, 9.0 * moment))
    assert bounds("com_offset") == pytest.approx((-0.5 * ARM, 0.5 * ARM))
    assert bounds("steady_torque") == pytest.approx((-0.5 * WEIGHT * ARM, 0.5 * WEIGHT * ARM))
    assert bounds("steady_force") == pytest.approx((-2.0 * WEIGHT, 2.0 * WEIGHT))
    assert bounds("pressure_centre") == pytest.approx((-ARM, ARM))
    # Down to no lag at all.
    slow = QUAD.rotors[0].model_copy(update={"time_constant": 0.1})
    mixed = QUAD.model_copy(update={"rotors": (slow, *QUAD.rotors[1:])})
    assert bounds("rotor_lag", vehicle=mixed)[0] == pytest.approx(-QUAD.rotors[1].time_constant)
    assert bounds("servo_lag", vehicle=OMAV)[0] == pytest.approx(-min(t.time_constant for t in OMAV.tilts))
    top = max(t.max_rate for t in OMAV.tilts)
    assert bounds("servo_rate_limit", vehicle=OMAV) == pytest.approx((0.2, top))
    assert scale("servo_rate_limit", vehicle=OMAV) == pytest.approx(-0.5 * min(8.0, top))
    assert [bounds(n)[1] / scale(n) for n in ("hub_moment", "translational_lift")] == pytest.approx([30.0, 25.0])


def test_a_followed_point_is_usually_a_tenth_of_an_arm_away():
    assert SensorPlace.scale(QUAD, SensorPlace.parameters[0]) == pytest.approx(0.1 * ARM)


def test_a_rotor_is_told_by_the_number_that_its_input_uses():
    cls = effect_class("rotor_effectiveness")
    k = QUAD.rotors[1].thrust_coefficient
    assert cls.in_the_file(QUAD, 0, 1) == ("rotor_1.thrust_coefficient", k, k)
    # A throttle's thrust is a polynomial: the coefficient says nothing of it, though the file may have one.
    changed = {"input": "throttle", "thrust_polynomial": (0.0, 1.0, 2.0), "thrust_coefficient": k}
    rotors = tuple(r.model_copy(update=changed) for r in QUAD.rotors)
    told = cls.in_the_file(QUAD.model_copy(update={"rotors": rotors}), 0, 1)
    assert told == ("rotor_1.thrust, factor", 1.0, 1.0)


def test_a_file_says_of_which_number_an_effect_is():
    vehicle = QUAD.model_copy(update={"center_of_mass": (0.1, 0.2, 0.3), "measured_at": (0.4, 0.5, 0.6)})
    for i in range(3):
        axis = "xyz"[i]
        classes = (effect_class("com_offset"), effect_class("inertia_error"), SensorPlace)
        said = [cls.in_the_file(vehicle, i, 0)[:2] for cls in classes]
        assert said == [
            (f"center_of_mass.{axis}", pytest.approx(vehicle.center_of_mass[i])),
            (f"inertia.{axis}{axis}", pytest.approx(MOMENTS[i])),
            (f"measured_at.{axis}", pytest.approx(vehicle.measured_at[i])),
        ]


def test_without_rotors_the_arm_is_where_half_of_the_mass_makes_the_inertia():
    wrench = QUAD.model_copy(update={"rotors": (), "inputs": "wrench"})
    assert 0.5 * QUAD.mass * arm_length(wrench) ** 2 == pytest.approx(QUAD.inertia.zz)
    assert arm_length(QUAD) == pytest.approx(ARM)


def table(**columns):
    t = 0.01 * np.arange(500)
    return Flight(pd.DataFrame({"t": t, **{k: np.broadcast_to(v, t.shape) for k, v in columns.items()}}))


def rotors(values):
    return table(**{f"cmd_rotor_{i}": v for i, v in enumerate(values)})


@pytest.mark.parametrize(("every", "seen"), [(4, True), (6, False)])
def test_commands_that_change_every_50_ms_do_not_show_how_they_are_followed(every, seen):
    values = 500.0 + np.arange(500) // every
    assert (coarse(rotors([values] * 4), [f"cmd_rotor_{i}" for i in range(4)]) is None) == seen


def test_one_tilt_that_moves_is_enough():
    still = {f"cmd_tilt_{i}": 0.2 for i in range(6)}
    assert still_tilts(OMAV, table(**still)) == "no tilt is commanded to move"
    assert still_tilts(OMAV, table(**{**still, "cmd_tilt_3": np.linspace(0.0, 0.1, 500)})) is None


def test_momenta_cancel_where_both_rotors_of_each_pair_turn_alike():
    pairs = {}
    for i, r in enumerate(OMAV.rotors):
        pairs.setdefault(r.tilt, []).append(i)
    speed = np.zeros((12, 500))
    for k, pair in enumerate(pairs.values()):
        speed[pair] = 600.0 + 50.0 * k + np.linspace(0.0, 80.0, 500)
    tilts = {f"cmd_tilt_{i}": 0.0 for i in range(6)}

    def said(values):
        return cancelling(OMAV, Flight(rotors(values).table.assign(**tilts)), "angular momenta")

    assert "cancel" in said(speed)
    apart = speed.copy()
    apart[pairs[4][0]] += 10.0
    assert said(apart) is None


def test_the_ground_is_out_of_reach_from_twenty_radii():
    radius = max(r.radius or 0.0 for r in QUAD.rotors)
    hidden = effect_class("ground_effect").hidden
    assert hidden(QUAD, table(pz=19.0 * radius)) is None
    assert "21 rotor radii" in hidden(QUAD, table(pz=np.linspace(21.0, 40.0, 500) * radius))


def test_a_voltage_that_does_not_fall_shows_no_sag():
    vehicle = QUAD.model_copy(update={"nominal_voltage": 16.0})
    hidden = effect_class("battery_sag").hidden
    assert hidden(vehicle, table(battery=16.0)) == "the recorded voltage does not change"
    assert hidden(vehicle, table(battery=np.linspace(16.0, 15.9, 500))) is None
    assert hidden(QUAD.model_copy(update={"nominal_voltage": None}), table(battery=16.0)) is None


def test_arms_stand_in_the_order_of_their_azimuth():
    order = arms(OMAV)
    azimuth = [np.arctan2(*OMAV.tilts[i].axis[1::-1]) for i in order]
    assert azimuth == sorted(azimuth)
    turned = OMAV.model_copy(update={"tilts": OMAV.tilts[3:] + OMAV.tilts[:3]})
    azimuth = [np.arctan2(*turned.tilts[i].axis[1::-1]) for i in arms(turned)]
    assert azimuth == sorted(azimuth)


def test_a_channel_is_missing_where_neither_it_nor_what_it_follows_from_is_there():
    turned = {"qw": 1.0, "qx": 0.0, "qy": 0.0, "qz": 0.0}
    place, felt = {"px": 0.0, "py": 0.0, "pz": 0.0}, {"ax": 0.0, "ay": 0.0, "az": 0.0}
    rates = {"wx": 0.0, "wy": 0.0, "wz": 0.0}

    def lacks(need, vehicle=QUAD, **columns):
        return missing_channel(need, vehicle, table(**columns)) is not None

    assert not lacks("velocity", **turned, **place)
    assert lacks("velocity", **place)
    assert lacks("velocity", **turned)
    assert not lacks("specific force", **felt)
    assert not lacks("specific force", **turned, **place)
    assert lacks("specific force", **turned)
    assert lacks("specific force", **place)
    assert not lacks("gyro or accelerometer", **felt)
    assert not lacks("gyro or accelerometer", **rates)
    assert lacks("gyro or accelerometer", **turned)
    marked = Flight(table(**rates).table, {"derived": ["wz"]})
    assert "derived from the attitude" in missing_channel("gyro", QUAD, marked)
    bare = QUAD.rotors[0].model_copy(update={"radius": None})
    assert lacks("radius", QUAD.model_copy(update={"rotors": (bare, *QUAD.rotors[1:])}))
    assert not lacks("radius")
