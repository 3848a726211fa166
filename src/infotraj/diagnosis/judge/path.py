"""Whether the path of the flights shows a force, or an accelerometer alone does."""

from __future__ import annotations

import numpy as np

from infotraj.comparing.equation_error import equation_error
from infotraj.comparing.statistics import statistics
from infotraj.diagnosis.measure.residual import FlightSamples
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.flight import VELOCITY, Flight

_LONG = 1.0  # s: a steady force is as large over seconds, and the noise of a position is small by then


def shows_on_path(tried: Fit, made: Fit) -> bool:
    """Whether the path of these flights shows a steady force, which `tried` has and `made` has not.

    What an accelerometer alone shows is its bias, and no force.
    """
    o = made.linear.observation
    flights = [_with_velocity(s) for s in o.samples]
    left = []
    for fit in (made, tried):
        model = o.model(fit.members)
        errors = [equation_error(model, f, window=_LONG, force_from="velocity") for f in flights]
        left.append(statistics(errors).rmse[:3])
    return bool(np.nansum(np.log(left[0] / left[1])) >= TELLS)


def _with_velocity(samples: FlightSamples) -> Flight:
    """The flight with the velocity that the diagnosis takes from its position, where none was logged."""
    flight, velocity = samples.flight, samples.prepared.recorded.velocity
    if flight.has(*VELOCITY) or velocity is None:
        return flight
    values = velocity.at(flight.t)
    return Flight(flight.table.assign(**dict(zip(VELOCITY, values.T, strict=True))), flight.meta)
