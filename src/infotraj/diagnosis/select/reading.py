"""What commands did between the rows of a log: held until the next, or stepped on by a faster controller.

A log thinned from 100 to 50 Hz holds every second command. Held over the rows that are missing, commands come late by
milliseconds: that looks like drag, damping or an offset of time. A log does not say which it was. So where its commands
are sparse the flights are read each way, and the reading counts under which they are more probable. Of a log of 200 Hz
beside a controller of 500 both readings are nearly alike: it is read as it stands, and delays and lags are less sure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from infotraj.diagnosis.gates.premises import command_step, new_command_step
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.select.around import Linear, linearised
from infotraj.diagnosis.select.choosing import searched
from infotraj.diagnosis.select.prior import EACH, STAMP, TIMES
from infotraj.dynamics.inputs import command_columns
from infotraj.flight import Flight, command_steps, stepped
from infotraj.importing.row_rate import averaged, held
from infotraj.sparse_commands import COMMAND_STEPS, MOST_STEPS
from infotraj.vehicle import Vehicle

SPARSE = 0.0075  # s between rows with commands: a controller of more than 133 Hz is usual
_DENSE = 0.002  # s between them: of closer ones a command is late by 0.75 ms at most, in the mean
_REPEATED = 0.5  # of the rows that repeat the commands before: more come of a controller that is slower than the log
_COUNTS = (2, 4)
_LATE = "actuation_delay"


def sparse(flight: Flight, vehicle: Vehicle) -> bool:
    """Whether commands may have run on between rows that are so far apart that it tells."""
    return ran_on(flight, vehicle) and command_step(flight, vehicle) > SPARSE


def ran_on(flight: Flight, vehicle: Vehicle) -> bool:
    """Whether a controller may have made more commands than the flight holds.

    Where the flight says how many, it is known; where commands were held over rows, they were rarer than these, and
    where rows hold means of what was logged, they hold all of it.
    """
    meta, t = flight.meta, flight.t
    known = COMMAND_STEPS in meta or held(meta, t) or averaged(meta, t) or not flight.has(*command_columns(vehicle))
    if known or round(command_step(flight, vehicle), 6) <= _DENSE:
        return False
    x = flight.get(*command_columns(vehicle))
    x = x[np.isfinite(x).all(axis=1)]
    return bool(np.mean((np.diff(x, axis=0) == 0.0).all(axis=1)) <= _REPEATED)


def as_read(flight: Flight, like: Flight) -> Flight:
    """The flight with as many steps of its commands as another reading of it has."""
    count = command_steps(like)
    return flight if count == command_steps(flight) else stepped(flight, count)


def as_healthy(flights: Sequence[Flight], healthy: Sequence[Flight], vehicle: Vehicle) -> list[Flight]:
    """The flights with commands as often as the healthy ones are read to have them: the controller is the same.

    Read otherwise on one side alone, they would come late there, and that would be told as a change.
    """
    every = min(new_command_step(f, vehicle) / command_steps(f) for f in healthy)
    counts = [round(command_step(f, vehicle) / every) if ran_on(f, vehicle) else 1 for f in flights]
    return [stepped(f, min(count, MOST_STEPS)) if count > 1 else f for f, count in zip(flights, counts, strict=True)]


def unread(candidate: Candidate, observation: Observation) -> float:
    """By how much a delay or lag of actuators (s) is unsure because commands may have run on between the rows of a log;
    0 for any other number.

    Held, or in the most steps of `_COUNTS`, they are later or sooner by the mean of what lies between: two readings
    that are as likely are half of their difference from their mean (Draper 1995).
    """
    declared = candidate.cls.declared
    follows = candidate.cls.place == "actuators" and declared is not None and declared.kind in TIMES
    if not follows or not any(ran_on(s.flight, observation.vehicle) for s in observation.samples):
        return 0.0
    return 0.25 * (1.0 - 1.0 / max(_COUNTS)) * observation.command_step


def as_commanded(observation: Observation, held: Sequence[Member], known: Sequence[Candidate]) -> Linear:
    """The model around the effects that it has, with commands read as the best set of effects is most probable.

    A log is read as it stands: that its commands made steps is said of it like an effect, and costs as much. Where that
    pays around the file as it is, it has to pay around the file as it is found to be, too: a declared lag that is twice
    the true one asks for earlier commands until it is corrected.
    """
    here = linearised(observation, held, known)
    if not any(sparse(s.flight, observation.vehicle) for s in observation.samples):
        return here
    if _most_probable(here, held) is observation:
        return here
    chosen, _, solution = searched(here)
    point = here.members(chosen, solution.theta, shift=0.0, straight=True)
    best = _most_probable(linearised(observation, point, known, like=here, anew=True), held)
    return here if best is observation else linearised(best, held, known)


def _most_probable(now: Linear, held: Sequence[Member]) -> Observation:
    """The flights under the reading of their commands that is most probable around a model.

    Readings are compared under the weights and columns of the first: how commands were made between rows changes what
    is left, and hardly what an effect does to it.
    """
    now = _early(now)
    best, score = now.observation, _within_bounds(now) + EACH
    for count in _COUNTS:
        stepping = _stepping(now.observation, held, count)
        made = replace(now, observation=stepping).moved(now.point)
        reached = -np.inf if made is None else _within_bounds(made)
        if reached > score:
            best, score = stepping, reached
    return best


def _early(now: Linear) -> Linear:
    """The same where commands may act as much before their stamps as stamps are inexact."""
    sooner = STAMP * now.observation.command_step
    columns = (
        replace(c, low=c.low - sooner / c.scale, lowest=c.lowest - sooner / c.scale) if c.candidate.name == _LATE else c
        for c in now.columns
    )
    return replace(now, columns=tuple(columns))


def _within_bounds(now: Linear) -> float:
    """How probable the best set is, nats, with numbers within their bounds: commands that are held over rows that are
    missing come late, and a fit would have them act before they were given."""
    chosen, scales, solution = searched(now)
    free = now.scorer(scales, bounded=False).solution(chosen)
    return solution.score - 0.5 * (now.absent.whole_error(solution.theta) - now.absent.whole_error(free.theta))


def _stepping(observation: Observation, held: Sequence[Member], count: int) -> Observation:
    """The flights, the sparse ones with commands that make `count` steps from row to row."""
    samples = tuple(
        replace(s, prepared=s.prepared.of(flight=stepped(s.flight, count)))
        if sparse(s.flight, observation.vehicle)
        else s
        for s in observation.samples
    )
    return replace(observation, samples=samples)
