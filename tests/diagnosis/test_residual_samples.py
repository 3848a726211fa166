"""Samples of the residual: how fine they are."""

import numpy as np
import pytest
from thrust_flights import ROW, fly, with_thrusts, without

from infotraj import rotations
from infotraj.diagnosis.measure.residual import flight_samples, measured_side
from infotraj.flight import Flight
from infotraj.models import Model


@pytest.mark.parametrize("times", [1, 5])
def test_a_log_of_a_kilohertz_gives_samples_of_five_milliseconds_each_the_mean_of_its_rows(times):
    flight = fly(seconds=8.0)[0]
    table = flight.table.assign(t=flight.t / times)  # only the times matter here
    for channel in flight_samples(Model(with_thrusts()), Flight(table)).channels:
        assert channel.step == pytest.approx(ROW)
        assert channel.rows.shape[1] == (0 if channel.difference else times)
        apart = np.diff(channel.last)[np.diff(channel.run) == 0]
        assert (apart == times).all()


def test_without_an_accelerometer_what_holds_the_vehicle_up_was_measured_all_the_same():
    """Of each step the velocity gained, and what gravity would have taken: the true specific force in world axes."""
    flight = without(fly(seconds=8.0)[0], "ax", "ay", "az")
    samples = flight_samples(Model(with_thrusts()), flight)
    (channel,) = [c for c in samples.channels if c.name == "velocity"]
    side = measured_side(samples, channel) / np.diff(flight.t[[channel.first, channel.last]], axis=0).T
    world = rotations.to_world(flight.get("qw", "qx", "qy", "qz"), fly(seconds=8.0)[0].get("ax", "ay", "az"))
    middle = 0.5 * (world[channel.first] + world[channel.last])
    np.testing.assert_allclose(side, middle, atol=0.1)
    assert side[:, 2].mean() == pytest.approx(9.81, abs=0.5)
