"""Samples of the residual: how fine they are."""

import numpy as np
import pytest
from thrust_flights import ROW, fly, with_thrusts

from infotraj.diagnosis.measure.residual import flight_samples
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
