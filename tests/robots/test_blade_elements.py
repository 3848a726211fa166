"""Rotors by blade-element momentum theory: momentum, power, closed forms, symmetry, a vehicle that flies."""

from __future__ import annotations

import numpy as np
import pytest

from infotraj.control.thrust_vector import AGILE, ThrustVectorController
from infotraj.experiment.hidden.cases import batches
from infotraj.experiment.hidden.config import read_study
from infotraj.robots.plant import aerodynamics
from infotraj.robots.plant.blade_elements import balanced, blades, loads
from infotraj.robots.plant.hiding import hide
from infotraj.robots.plant.plant import Plant
from infotraj.robots.plant.truth import Blades, Truth
from infotraj.trajectories.standard import Extent, standard
from infotraj.vehicle import load_vehicle

STUDY = read_study("config/studies/hidden_effects.yaml")
VEHICLE = load_vehicle("config/vehicles/agile_quadrotor.yaml")
VALUES = STUDY.vehicles["agile_quadrotor"].richer["blade_elements"].parameters
TRUTH = hide(VEHICLE, [("blade_elements", VALUES)])
R, HOVER = VEHICLE.rotors[0].radius, 1059.0
STILL = np.zeros(2)


def table(**changes):
    given = Blades(**{**TRUTH.blades.model_dump(), **changes})
    return aerodynamics.blade_table(Truth.ideal(VEHICLE).model_copy(update={"blades": given}))[0]


def loaded(across=0.0, along=0.0, w=HOVER, blade=None, tilting=STILL, start=6.0):
    out = np.empty(6)
    inflow = balanced(table() if blade is None else blade, R, w, across, along, tilting, start, out)
    return out, inflow


def test_the_vehicle_file_holds_what_a_thrust_stand_reads():
    out, _ = loaded()
    rotor = VEHICLE.rotors[0]
    assert out[2] / HOVER**2 == pytest.approx(rotor.thrust_coefficient, rel=1e-3)
    assert -out[5] / out[2] == pytest.approx(rotor.moment_constant, rel=1e-3)
    assert 4 * out[2] == pytest.approx(VEHICLE.mass * VEHICLE.gravity, rel=1e-3)
    # thrust is k_F w^2 at any speed of a rotor that stands
    assert loaded(w=2000.0)[0][2] / 2000.0**2 == pytest.approx(rotor.thrust_coefficient, rel=1e-3)
    assert np.abs(out[[0, 1, 3, 4]]).max() < 1e-12


@pytest.mark.parametrize(("across", "along"), [(0.0, 0.0), (0.0, 6.0), (8.0, 0.0), (15.0, -4.0), (18.0, 5.0)])
def test_blades_and_momentum_theory_agree_on_the_thrust(across, along):
    out, inflow = loaded(across, along)
    area = np.pi * R**2
    assert out[2] == pytest.approx(2 * 1.2 * area * inflow * np.hypot(across, along + inflow), rel=1e-5)


@pytest.mark.parametrize("climb", [0.0, 4.0])
def test_without_profile_drag_the_shaft_s_power_is_thrust_times_the_air_s_speed_through_the_disc(climb):
    out, inflow = loaded(along=climb, blade=table(drag=1e-9, drag_rise=1e-9))
    assert -out[5] * HOVER == pytest.approx(out[2] * (climb + inflow), rel=1e-6)


def test_thrust_follows_the_closed_form_of_small_angles():
    # constant chord, no cutout, theta = c / x: C_T = sigma a / 2 (c / 2 - lambda / 2) (Leishman, 3.2)
    blade = table(root_chord=0.01, tip_chord=0.01, cutout=0.0, pitch=0.02, drag=1e-9, drag_rise=1e-9)
    out, inflow = np.empty(6), 0.5
    loads(blade, R, HOVER, 0.0, 0.0, STILL, inflow, out)
    solidity, tip = 3 * 0.01 / (np.pi * R), HOVER * R
    closed = 0.25 * solidity * TRUTH.blades.lift_slope * (0.02 / (2 * np.pi * R) - inflow / tip)
    assert out[2] / (1.2 * np.pi * R**2 * tip**2) == pytest.approx(closed, rel=0.02)


def test_forward_flight_lifts_and_drags_and_climbing_costs_thrust():
    hover, inflow = loaded()
    before = hover[2]
    for speed in (4.0, 8.0, 12.0, 16.0):
        out, less = loaded(across=speed)
        assert out[2] > before  # translational lift
        assert less < inflow
        assert out[0] > 0  # to the rear
        before, inflow = out[2], less
    lift = (loaded(across=6.0)[0][2] - hover[2]) / 36.0
    assert 2e-3 < lift < 6e-3  # N s^2/m^2, as published for such rotors
    assert loaded(along=5.0)[0][2] < hover[2] < loaded(along=-3.0)[0][2]


def test_a_rotor_that_turns_with_the_body_resists():
    # the edge that rises has less thrust: rear about the side axis, side about the rear axis
    assert loaded(across=0.0, tilting=np.array([5.0, 0.0]))[0][4] > loaded()[0][4]
    assert loaded(across=0.0, tilting=np.array([0.0, 5.0]))[0][3] < loaded()[0][3]


def wrench(velocity, rate=(0.0, 0.0, 0.0), speeds=(HOVER,) * 4):
    rotors, blade = aerodynamics.rotor_table(VEHICLE, TRUTH), aerodynamics.blade_table(TRUTH)
    places = np.array([r.position for r in VEHICLE.rotors])
    axes = np.array([r.axis for r in VEHICLE.rotors])
    thrust, out = np.empty(4), np.zeros(6)
    square = np.square(speeds)
    blades(rotors, blade, square, np.array(velocity), np.array(rate), places, axes, thrust, out)
    aerodynamics.rotor_wrench(rotors, thrust, places, axes, out)
    return out, thrust


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.5])
def test_mirrored_rotors_cancel_what_a_symmetric_vehicle_cannot_have(heading):
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    out, thrust = wrench(10.0 * ahead)
    assert out[:3] @ ahead < -0.3  # drag
    assert out[:3] @ np.cross([0, 0, 1], ahead) == pytest.approx(0.0, abs=1e-9)
    assert out[3:] @ ahead == pytest.approx(0.0, abs=1e-9)  # no roll about the way it flies
    assert out[5] == pytest.approx(0.0, abs=1e-9)
    assert thrust == pytest.approx([thrust[0]] * 4)


def test_turning_and_wind_from_all_sides_are_damped():
    for axis in range(3):
        rate = np.zeros(3)
        rate[axis] = 4.0
        assert wrench(np.zeros(3), rate)[0][3 + axis] < 0
        velocity = np.zeros(3)
        velocity[axis] = 3.0
        assert (wrench(velocity)[0] - wrench(np.zeros(3))[0])[axis] < (0.0 if axis < 2 else 0.5)


@pytest.mark.parametrize(("kind", "speed"), [("fast_circle", 10.0), ("fast_lemniscate", 20.0)])
def test_the_vehicle_flies_fast_and_the_file_cannot_explain_it(kind, speed):
    reference = standard(kind, 10.0, Extent(size=0.6 * speed, speed=speed, tilt=0.0), np.random.default_rng(4))
    controller = ThrustVectorController(VEHICLE, reference, AGILE)
    flight, true = Plant(VEHICLE, TRUTH, settle=2.0).fly_with_truth(reference, controller, np.random.default_rng(5))
    gone = flight.get("px", "py", "pz") - flight.get("ref_px", "ref_py", "ref_pz")
    assert np.nanmax(np.abs(gone)) < 0.2 * speed
    fast = np.linalg.norm(true[["vx", "vy", "vz"]], axis=1)
    assert fast.max() > 0.7 * speed
    thrusts = true[[f"thrust_{k}" for k in range(4)]].to_numpy()
    told = VEHICLE.rotors[0].thrust_coefficient * true[[f"rotor_{k}" for k in range(4)]].to_numpy() ** 2
    assert np.std((thrusts / told)[fast > 0.6 * speed]) > 0.03


def test_it_has_its_place_in_the_study():
    cases = {b.case.name for b in batches(STUDY) if b.case.vehicle == "agile_quadrotor"}
    assert cases == {"agile_quadrotor/richer/blade_elements"}
