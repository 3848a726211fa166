"""Flights made ready to be questioned: samples, their transforms and blocks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.comparing.unscored import unscored
from infotraj.diagnosis.gates.level import unmeasured
from infotraj.diagnosis.gates.premises import command_step
from infotraj.diagnosis.linear.observation import Observation
from infotraj.diagnosis.linear.sums import blocks
from infotraj.diagnosis.measure.residual import FlightSamples, flight_samples
from infotraj.diagnosis.noise.spectra import binned, spectra, transforms
from infotraj.flight import Flight
from infotraj.models import Model


def observe(
    model: Model, flights: Sequence[Flight], start: float | None = None, stop: float | None = None, clear: float = 0.0
) -> Observation:
    """The flights as samples. InputError where a flight has no usable sample on any channel.

    clear: s before and after the ground that are left out.
    """
    samples = tuple(_samples(model, f, start, stop, clear) for f in flights)
    by = tuple(tuple(turns) for turns in transforms(samples))
    empty = [[np.zeros((len(c.last), 3, 1)) for c in s.channels] for s in samples]
    step = max(command_step(f, model.vehicle) for f in flights)
    sideways, balance = (frozenset().union(*x) for x in zip(*map(unmeasured, flights), strict=True))
    cut = blocks(spectra(samples, by, binned(by, empty)))
    return Observation(model.vehicle, samples, by, cut, frozenset(sideways), step, balance=frozenset(balance))


def _samples(model: Model, flight: Flight, start: float | None, stop: float | None, clear: float) -> FlightSamples:
    s = flight_samples(model, flight, start, stop, clear)
    if any(c.name in ("force", "velocity", "rate") for c in s.channels):
        return s
    what = f"{s.flight.meta.get('source', 'flight')}: nothing to compare"
    raise unscored(what, [f"{k}: {v}" for k, v in s.reasons.items()], s.left_out, len(s.logged.t))
