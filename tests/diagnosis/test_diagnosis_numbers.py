"""Numbers of the file as an effect has them, and what is known of them before a flight."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from infotraj import rotations
from infotraj.diagnosis.gates.level import as_level, unmeasured
from infotraj.diagnosis.judge import numbers
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.select.prior import Scales, is_file_number, spikes
from infotraj.dynamics.actuators import body_wrench
from infotraj.effects import Declared, Effect, Parameter, effect_class
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.flight import ATTITUDE, Flight
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")


@pytest.mark.parametrize("rotor", range(4))
@pytest.mark.parametrize("axis", range(3))
def test_a_corrected_file_makes_the_torque_that_was_found(rotor, axis):
    """An arm of 1 mm that the effect adds, as a moment constant or a place in the file: the same torque of a thrust."""
    arm, speeds = 1e-3, np.full(4, 900.0)
    name, declared, per = RotorTorque.in_the_file(VEHICLE, axis, rotor)
    old = VEHICLE.rotors[rotor]
    if axis == 2:
        assert name == f"rotor_{rotor}.moment_constant"
        new = old.model_copy(update={"moment_constant": declared + per * arm})
    else:
        place = list(old.position)
        k = "xyz".index(name[-1])
        assert place[k] == declared
        place[k] += per * arm
        new = old.model_copy(update={"position": tuple(place)})
    rotors = tuple(new if i == rotor else r for i, r in enumerate(VEHICLE.rotors))
    changed = VEHICLE.model_copy(update={"rotors": rotors})
    before, after = (body_wrench(v, speeds, np.zeros(0)) for v in (VEHICLE, changed))
    thrust = old.thrust_coefficient * 900.0**2
    expected = np.zeros(6)
    expected[3 + axis] = thrust * arm
    np.testing.assert_allclose(after - before, expected, atol=1e-9 * thrust)


def test_a_number_that_is_found_and_not_named_is_told_of_the_file(monkeypatch):
    """A lag that is 75 % probable may be the file's: it takes nearly all of an error off, and has to be said."""
    lag, delay = (Candidate(effect_class(n), effect_class(n).parameters) for n in ("rotor_lag", "actuation_delay"))
    linear = SimpleNamespace(
        columns=[SimpleNamespace(candidate=c, scale=0.01) for c in (lag, delay)],
        spike=lambda _: np.ones(2),
        observation=SimpleNamespace(command_step=0.005, samples=()),
    )
    made = SimpleNamespace(
        linear=linear, scales=None, solution=SimpleNamespace(theta=np.array([5.0, 5.0])), labels=("rotor_lag",)
    )
    monkeypatch.setattr(numbers, "told_errors", lambda *_: np.full(2, 0.1))

    def told(named):
        return [c.candidate.name for _, c, *_ in numbers.off(made, named)]

    assert told(()) == ["rotor_lag", "actuation_delay"]
    assert told({"rotor_lag"}) == ["actuation_delay"]


def test_clocks_are_no_worse_for_what_a_file_says_of_its_vehicle():
    assert Scales(9.0).of("clock") == Scales(0.3).of("clock") == 1.0
    assert Scales(0.0).of("clock") == 0.0
    assert Scales(9.0, {"mass": 3.0}).of("mass") == 3.0
    assert Scales(9.0, {"mass": 3.0}).of("rotors") == 9.0


def spread(cls, size, command_step=0.0, common=3.0):
    return spikes([(Candidate(cls, cls.parameters), size)], Scales(common), command_step, VEHICLE)[0]


def test_an_effect_says_itself_what_a_file_has_wrong_of_it():
    class Sag(Effect):
        """The arms hang by an angle."""

        name, place = "sag", "thrust"
        parameters = (Parameter("angle", "rad", 0.02, (-0.3, 0.3)),)
        declared = Declared("angle", 0.1, "arms, lower by")

    class Unheard(Sag):
        name, declared = "unheard", None

    assert is_file_number(Candidate(Sag, Sag.parameters))
    assert spread(Sag, 0.02) == pytest.approx(0.3)
    assert Sag.in_the_file(VEHICLE, 0, 0) == ("arms, lower by", 0.0, 1.0)
    assert not is_file_number(Candidate(Unheard, Unheard.parameters))
    assert spread(Unheard, 0.02) == 0.0


def test_times_are_off_by_a_share_of_what_is_declared_and_no_better_than_commands_are_stamped():
    longest = max(r.time_constant for r in VEHICLE.rotors)
    assert spread(effect_class("rotor_lag"), -0.03) == pytest.approx(3.0 * 0.02 * longest / 0.03)
    assert spread(effect_class("servo_lag"), 0.03) == 0.0
    assert spread(effect_class("actuation_delay"), 0.015, 0.02) == pytest.approx(np.hypot(1 / 15, 0.002 / 0.015))
    # A centre of mass is balanced to a third of a millimetre: on a small vehicle more than a share of its arm.
    assert spread(effect_class("com_offset"), 0.001) == pytest.approx(3.0 * np.hypot(0.05, 0.33))


def test_a_vehicle_that_is_taken_as_level_is_level():
    t = np.arange(0.0, 1.0, 0.01)
    flight = as_level(Flight(pd.DataFrame({"t": t, "px": 0.0, "py": 0.0, "pz": 1.0})))
    np.testing.assert_array_equal(rotations.matrix(flight.get(*ATTITUDE)), np.broadcast_to(np.eye(3), (100, 3, 3)))
    assert unmeasured(flight) == (frozenset({"vx", "vy"}), frozenset({"vz", "tx", "ty", "tz"}))


@pytest.mark.parametrize(
    ("effect", "name", "unit"),
    [
        ("time_offset", "clock of the sensors, later by", "s"),
        ("mass_offset", "mass", "kg"),
        ("com_offset", "center_of_mass.x", "m"),
        ("rotor_effectiveness", "rotor_0.thrust_coefficient", "N s^2/rad^2"),
        ("moment_scale", "moment_constant of all rotors, factor", ""),
    ],
)
def test_a_number_of_the_file_has_the_unit_of_the_file(effect, name, unit):
    cls = effect_class(effect)
    candidate = Candidate(cls, tuple(p for p in cls.parameters if not p.index))
    said, _, _ = cls.in_the_file(VEHICLE, 0, 0)
    assert said == name
    assert numbers._unit(candidate, candidate.form[0].name, said) == unit


def test_a_vehicle_without_rotors_has_no_numbers_of_rotors():
    pushed = VEHICLE.model_copy(update={"inputs": "wrench", "rotors": ()})
    words = {x: effect_class(x).in_the_file(pushed, 0, 0)[0] for x in ("rotor_lag", "moment_scale", "mass_offset")}
    assert words == {
        "rotor_lag": "time_constant of the wrench, more by",
        "moment_scale": "torque about thrust_axis, factor",
        "mass_offset": "mass",
    }
    assert effect_class("rotor_lag").in_the_file(VEHICLE, 0, 0)[0] == "time_constant of the rotors, more by"
