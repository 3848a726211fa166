"""A flight of which a part is asked: the same predictions there, none elsewhere; and turns that are not predicted."""

from pathlib import Path

import fast_flyer
import numpy as np
import pytest

from infotraj.effects import effect_class
from infotraj.flight import RATE, Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

QUADROTOR = load_vehicle(Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml")


@pytest.fixture(scope="module")
def flown():
    return Flight(fast_flyer.fly(Path(__file__).parents[2] / "config" / "vehicles" / "quadrotor.yaml", 20.0, 4))


def made(name, **values):
    return effect_class(name)(**values)


@pytest.mark.parametrize(
    "effect",
    [
        made("battery_sag", rate=0.02),
        made("sensor_lag", time_constant=0.02),
        made("rotor_lag", extra_time_constant=0.03),
        made("suspended_load", mass=0.05, length=0.5),
    ],
    ids=lambda e: e.name,
)
def test_a_part_is_predicted_as_in_the_whole_flight(flown, effect):
    """What a flight began with, time, lags and where commands were, is that of the whole of it."""
    model = Model(QUADROTOR, [effect])
    t = flown.t
    asked = ((t >= 6.0) & (t < 8.0)) | ((t >= 15.0) & (t < 16.0))
    off = 0.0 if effect.name == "suspended_load" else 3.0  # a load swings since it is in the air
    airborne = (t >= off) & (t < 19.0)
    close = 1e-3 if off == 0.0 else 1e-6  # where it swings hangs on the path of the whole part
    whole, prepared = model.predict(flown), model.prepare(flown).part(asked, airborne)
    part = model.predict(prepared)
    assert part.t[0] == pytest.approx(max(off - 1.5, 0.0), abs=0.02)
    assert part.t[-1] == pytest.approx(17.5, abs=0.02)
    first = int(np.searchsorted(t, part.t[0]))
    there = np.flatnonzero(asked)
    for name in ("specific_force", "specific_force_mean", "angular_acceleration", "angular_acceleration_mean"):
        np.testing.assert_allclose(getattr(part, name)[there - first], getattr(whole, name)[there], rtol=0, atol=close)
    far = (part.t > 10.0) & (part.t < 13.0)
    assert np.isnan(part.specific_force[far]).all()


def test_what_was_commanded_last_before_a_part_acts_in_it(flown):
    seldom = flown.table.copy()
    for k in range(4):
        seldom.loc[np.arange(len(seldom)) % 800 != 0, f"cmd_rotor_{k}"] = np.nan  # every 4 s
    flight, t = Flight(seldom), flown.t
    asked = (t >= 10.0) & (t < 11.0)
    model = Model(QUADROTOR)
    whole, part = model.predict(flight), model.predict(model.prepare(flight).part(asked, asked))
    there = np.flatnonzero(asked) - int(np.searchsorted(t, part.t[0]))
    np.testing.assert_allclose(part.specific_force[there], whole.specific_force[asked], rtol=0, atol=1e-6)


def test_beside_a_turn_that_is_not_predicted_forces_are_those_of_the_recorded_one(flown):
    """A torque that is predicted wrong accelerates no point of the body where it is not believed."""
    table = flown.table.copy()
    table["cmd_rotor_0"] *= 1.1  # tilts the prediction about x and y
    prepared = Model(QUADROTOR).prepare(Flight(table))
    offset = Model(QUADROTOR, [made("com_offset", r=(0.0, 0.0, 0.05))])
    centred = Model(QUADROTOR)
    believed = offset.predict(prepared).specific_force - centred.predict(prepared).specific_force
    recorded = prepared.turning((True, True, True))
    measured = offset.predict(recorded).specific_force - centred.predict(recorded).specific_force
    turn = np.gradient(flown.get(*RATE), flown.t, axis=0)
    w = flown.get(*RATE)
    arm = np.array([0.0, 0.0, 0.05])
    wanted = -np.cross(turn, arm) - np.cross(w, np.cross(w, arm))
    inside = (flown.t > 2.0) & (flown.t < 19.0)
    size = np.sqrt((wanted[inside] ** 2).mean())
    assert np.sqrt(((measured - wanted)[inside, :2] ** 2).mean()) < 0.2 * size
    assert np.sqrt(((believed - wanted)[inside, :2] ** 2).mean()) > size
