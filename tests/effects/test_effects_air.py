"""The air: what a wind may be."""

from pathlib import Path

from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.effects import catalogue
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")


def test_a_wind_is_level_but_for_what_slopes_and_thermals_make():
    wind = catalogue()["wind"]
    x, y, z = places(Candidate(wind, wind.parameters), VEHICLE)
    assert (x.low, x.high) == (y.low, y.high) == (-25.0, 25.0)
    assert (z.low, z.high) == (-3.0, 3.0)
    assert z.scale < x.scale == y.scale
