"""What commands did between the rows of a log: held until the next, or stepped on by a faster controller.

A log thinned from 100 to 50 Hz holds every second command. Held over the rows that are missing, commands come late by
milliseconds: that looks like drag, damping or an offset of time. A log does not say which it was. So where its commands
are sparse the flights are read each way, and the reading counts under which they are more probable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from infotraj.diagnosis.gates.premises import command_step
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.select.around import Linear, linearised
from infotraj.diagnosis.select.choosing import searched
from infotraj.dynamics.inputs import command_columns
from infotraj.flight import COMMAND_STEPS, Flight, stepped
from infotraj.vehicle import Vehicle

_SPARSE = 0.0075  # s between rows with commands: a controller of more than 133 Hz is usual
_COUNTS = (2, 4)


def sparse(flight: Flight, vehicle: Vehicle) -> bool:
    """Whether a controller may have made more commands than the flight holds; where it says how many, it is known."""
    known = COMMAND_STEPS in flight.meta or not flight.has(*command_columns(vehicle))
    return not known and command_step(flight, vehicle) > _SPARSE


def as_commanded(observation: Observation, held: Sequence[Member], known: Sequence[Candidate]) -> Linear:
    """The model around the effects that it has, with commands read as the best set of effects is most probable.

    Both readings are as likely before a flight is seen; they are compared under the weights and columns of the first:
    how commands were made between rows changes what is left, and hardly what an effect does to it.
    """
    here = linearised(observation, held, known)
    if not any(sparse(s.flight, observation.vehicle) for s in observation.samples):
        return here
    best, score = observation, _within_bounds(here)
    for count in _COUNTS:
        stepping = _stepping(observation, held, count)
        made = replace(here, observation=stepping).moved(here.point)
        if made is None:
            continue
        reached = _within_bounds(made)
        if reached > score:
            best, score = stepping, reached
    return here if best is observation else linearised(best, held, known)


def _within_bounds(now: Linear) -> float:
    """How probable the best set is, nats, with numbers within their bounds: commands that are held over rows that are
    missing come late, and a fit would have them act before they were given."""
    chosen, scales, solution = searched(now)
    free = now.scorer(scales, bounded=False).solution(chosen)
    return solution.score - 0.5 * (now.absent.whole_error(solution.theta) - now.absent.whole_error(free.theta))


def _stepping(observation: Observation, held: Sequence[Member], count: int) -> Observation:
    """The flights, the sparse ones with commands that make `count` steps from row to row."""
    model = observation.model(held)
    samples = tuple(
        replace(s, prepared=model.prepare(stepped(s.flight, count))) if sparse(s.flight, observation.vehicle) else s
        for s in observation.samples
    )
    return replace(observation, samples=samples)
