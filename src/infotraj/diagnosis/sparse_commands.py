"""What commands did between the rows of a log: held until the next, or stepped on by a faster controller.

A log thinned from 100 to 50 Hz holds every second command. Held over the rows that are missing, commands come late by
milliseconds: that looks like drag, damping or an offset of time. A log does not say which it was. So where its commands
are sparse the flights are read both ways, and the reading under which less is missing counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from infotraj.diagnosis.allowance import TIMING
from infotraj.diagnosis.candidates import Candidate
from infotraj.diagnosis.driving_noise import unweighted, weighted
from infotraj.diagnosis.fitting import Fit, fit
from infotraj.diagnosis.noise import left_by_richest, started
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.premises import command_step
from infotraj.diagnosis.sensitivities import sensitivities
from infotraj.diagnosis.silent import silent_axes
from infotraj.dynamics.inputs import command_columns
from infotraj.flight import COMMAND_STEPS, Flight, stepped
from infotraj.vehicle import Vehicle

_SPARSE = 0.0075  # s between rows with commands
_COUNTS = (2, 4)
_CLEARLY = 10.0  # squared error, in noise variances, that steps must spare before they are believed
_EACH = 2.0  # the same, that a fitted number must spare (Akaike 1974)


def sparse(flight: Flight, vehicle: Vehicle) -> bool:
    """Whether a controller may have made more commands than the flight holds; where it says how many, it is known."""
    known = COMMAND_STEPS in flight.meta or not flight.has(*command_columns(vehicle))
    return not known and command_step(flight, vehicle) > _SPARSE


def between_rows(flights: Sequence[Flight], vehicle: Vehicle, count: int) -> list[Flight]:
    """The flights, the sparse ones with commands that make `count` steps from row to row."""
    return [stepped(f, count) if sparse(f, vehicle) else f for f in flights]


def likeliest_steps(observation: Observation, members: Sequence[Member], absent: Sequence[Candidate]) -> int:
    """How many steps commands made between two rows, if they did not hold: by what the richest model leaves."""
    # A filter in the sensors, or wind beside a drag, looks like commands that came late: beside them nothing is told.
    told = [c for c in absent if c.name != "sensor_lag" and not c.cls.beside]
    base = sensitivities(observation, members, told)
    observation = started(observation.without_axes(silent_axes(observation.samples, base.joint).keys()), base.joint)
    model = observation.model(members)
    left = []
    for count in _COUNTS:
        flights = between_rows([s.flight for s in observation.samples], observation.vehicle, count)
        samples = [replace(s, prepared=model.prepare(f)) for s, f in zip(observation.samples, flights, strict=True)]
        residuals = [s.residual(model) for s in samples]
        joint = [
            [np.concatenate([r[:, :, None], x[:, :, 1:]], axis=2) for r, x in zip(residual, flight, strict=True)]
            for residual, flight in zip(residuals, base.joint, strict=True)
        ]
        left.append(left_by_richest(observation, joint))
    return _COUNTS[int(np.argmin(left))]


def fits_better(as_steps: tuple[Observation, Fit], as_held: tuple[Observation, Fit]) -> bool:
    """Whether what was found when commands are read as steps explains the flights better than when they are held.

    Each an observation and what was fitted to it; both are weighed by the noise of the second, samples all
    alike. Steps that come early and a delay that undoes it are no better explanation than commands that were held.
    """
    held, before = as_held
    steps, after = as_steps
    if _timing(after) > _timing(before):
        return False
    steps = replace(unweighted(steps), noise=held.noise, ignored=held.ignored)
    again = fit(steps, after.members)
    if weighted(held):
        before = fit(unweighted(held), before.members)
    if again is None or before is None:
        return False
    spared = before.cost / _count(held) - again.cost / _count(steps)
    more = len(again.at_bound) - len(before.at_bound)
    return spared * _count(held) > _CLEARLY + _EACH * more


def _timing(found: Fit) -> int:
    return sum(m.candidate.name in TIMING for m in found.members)


def _count(observation: Observation) -> int:
    return sum(3 * len(c.last) for s in observation.samples for c in s.channels)
