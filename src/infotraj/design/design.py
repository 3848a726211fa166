"""Designs the next flight: many candidate motions are tried on paper, the best are varied, the winner is simulated.

A search by drawing and varying (cross-entropy method: Rubinstein 1999): a candidate costs one evaluation of its
columns, no flight. What is asked of it is either an open question of the diagnosis, a pair of effects, or a number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from infotraj.comparing.shaken import told_by_velocity
from infotraj.design.expected import Limits, expected, limits
from infotraj.design.paths import Room, calmer, drawn, path, varied
from infotraj.design.questions import Asked, determined, everything, open_questions, separated
from infotraj.design.simulation import Simulated, simulated
from infotraj.design.worth import Gram, Question
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.diagnosis.linear.candidates import Candidate, places, raw
from infotraj.diagnosis.linear.observation import Observation
from infotraj.effects.base import Parameter
from infotraj.errors import InputError, problem
from infotraj.flight import POSITION, Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle

CANDIDATES = 60
_ROUNDS, _KEPT, _SPREAD = 2, 4, 0.12  # how often the best are varied, how many, by how much
_CALMER = 0.8  # the size of a motion that asked too much is reduced by this
_TRIES = 8
_EVERY = 2  # rows of a candidate that are looked at: 50 Hz, and all that is believed is slower than 20 Hz
_INSIDE = 0.02  # of a rotor's range that stays in reserve for what a controller adds
_AT_LIMIT = 0.02  # of the time at most, in simulation
_BESIDE = 0.25  # m from the reference, and so from the box, at most, in simulation


@dataclass(frozen=True)
class Told:
    """What a flight would tell of one question: probability that it is decided, now, after another flight like the
    last flown, and after the design; or an effect's standard errors at the same three times, and those of now as
    shares of how far the number is from that of no effect."""

    words: str
    now: float | None = None
    again: float | None = None
    after: float | None = None
    numbers: tuple[str, ...] = ()
    errors_now: tuple[float, ...] = ()
    errors_again: tuple[float, ...] = ()
    errors_after: tuple[float, ...] = ()
    shares_now: tuple[float, ...] = ()


@dataclass(frozen=True)
class Design:
    """The reference, what it would tell, and what the vehicle does along it.

    inputs (n, rotors); limits: of the rotors; room; flown: in simulation, None where that is not possible and why.
    """

    reference: Reference
    told: tuple[Told, ...]
    inputs: Array
    limits: Limits
    room: Room
    flown: Simulated | None
    not_flown: str
    tried: int


@dataclass(frozen=True)
class _Tried:
    genes: Array
    reference: Reference
    flight: Flight
    value: float


def room_of(
    flown: Sequence[Flight], size: Sequence[float], seconds: float, speed: float, tilt: float, model: Model
) -> Room:
    """A box of this size (m) around the middle of what was flown; where no position was logged, around 0, 0, 1.5 m."""
    places = [f.get(*POSITION) for f in flown if f.has(*POSITION)]
    center = np.array([0.0, 0.0, 1.5])
    if places:
        every = np.concatenate(places)
        center = np.nanmean([np.nanpercentile(every, q, axis=0) for q in (2, 98)], axis=0)
    v = model.vehicle
    return Room(np.array(size, dtype=float), center, seconds, speed, tilt, bool(v.tilts), v.gravity)


def design(
    found: Diagnosis,
    flown: Sequence[Flight],
    room: Room,
    *,
    separate: tuple[str, str] | None = None,
    determine: str | None = None,
    candidates: int = CANDIDATES,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Design:
    """The flight in `room` that tells most next, given the diagnosis of the flights flown.

    separate: two effects to be told apart; determine: one whose numbers are to be narrowed; by default what the
    diagnosis left open, and where nothing is open all numbers. UsageError, InputError: see `questions`; InputError
    where no motion keeps the rotors in their limits.
    """
    if not found.judged or not found.search.known:
        why = next(iter(found.refused.values()), "no effect can be tested on these flights")
        raise InputError(problem(f"nothing could be judged: {why}", "flights that can be", "Mend the log or the file."))
    asked = [separated(found, *separate)] if separate else [] if determine else open_questions(found)
    labels: tuple[str, ...] = ()  # of the effects whose numbers are told
    questions = [a.question for a in asked]
    if determine:
        one, label = determined(found, determine)
        questions, labels = [one], (label,)
    elif not asked:
        whole, labels = everything(found)
        questions = [whole]
    model = found.search.observation.model(list(questions[0].first.members))
    bound = limits(model.vehicle, list(flown))
    like = _as_read(found, flown[-1])
    rng, draws = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])

    def value(grams: list[Gram]) -> float:
        if asked:
            return min(q.told_apart(g, np.random.default_rng(seed))[1] for q, g in zip(questions, grams, strict=True))
        q, g = questions[0], grams[0]
        if determine is None:
            return q.information(g)
        now, after, _ = q.errors_after(g, labels[0])
        return -float(np.mean(np.log(np.maximum(after, 1e-300) / np.maximum(now, 1e-300))))

    def grams_of(flight: Flight) -> list[Gram]:
        thin = Flight(flight.table.iloc[::_EVERY].reset_index(drop=True), flight.meta)
        return [q.gram(q.observed(thin)) for q in questions]

    best: list[_Tried] = []
    for k in range(candidates):
        fresh = k < candidates // (_ROUNDS + 1) or not best
        genes = drawn(room, rng) if fresh else varied(best[k % len(best)].genes, _SPREAD, rng)
        made = _within(model, genes, room, bound, like)
        worth = value(grams_of(made.flight)) if made is not None else -np.inf
        if made is not None and np.isfinite(worth):
            best = sorted([*best, replace(made, value=worth)], key=lambda x: -x.value)[:_KEPT]
        progress(k + 1, candidates)
    if not best:
        raise InputError(_no_motion())
    chosen, sim, why = _flyable(model, best, room, bound, like)
    grams = grams_of(chosen.flight)
    again = [q.gram(_last(found)) for q in questions]
    if asked:
        told = tuple(
            Told(a.words, _now(a), q.told_apart(b, draws)[0], q.told_apart(g, draws)[0])
            for a, q, g, b in zip(asked, questions, grams, again, strict=True)
        )
    else:
        told = tuple(_numbers(questions[0], grams[0], again[0], labels))
    return Design(chosen.reference, told, _rotor_inputs(chosen.flight), bound, room, sim, why, candidates)


def _as_read(found: Diagnosis, flight: Flight) -> Flight:
    """A flown flight as the diagnosis has read the flights: its forces from the velocity where theirs were."""
    return told_by_velocity(flight) if found.by_velocity else flight


def at_random(model: Model, flown: Sequence[Flight], room: Room, seed: int = 0) -> Reference:
    """A motion drawn as the search draws its first, in the same limits, and made calmer alike; nothing is asked of it.

    InputError where no motion keeps the rotors in their limits.
    """
    rng, bound = np.random.default_rng([seed, 0]), limits(model.vehicle, list(flown))
    for _ in range(_TRIES):
        made = _within(model, drawn(room, rng), room, bound, flown[-1])
        if made is not None:
            return _flyable(model, [made], room, bound, flown[-1])[0].reference
    raise InputError(_no_motion())


def largest(model: Model, motion: Callable[[float], Reference], flown: Sequence[Flight]) -> float:
    """The largest share (1, 0.8, 0.64 ..) of a motion that the rotors can fly, `motion(share)`.

    InputError where they can fly none of eight.
    """
    bound = limits(model.vehicle, list(flown))
    for share in _CALMER ** np.arange(_TRIES):
        if _can_fly(model, expected(model, motion(share), flown[-1]), bound):
            return float(share)
    raise InputError(_no_motion())


def _no_motion() -> str:
    what = "no motion in this room keeps the rotors within their limits"
    return problem(what, "room to move, and rotors that can more than hover", "Give a larger --box.")


def _can_fly(model: Model, flight: Flight, bound: Limits) -> bool:
    return not model.vehicle.rotors or bound.passed(_rotor_inputs(flight)) <= -_INSIDE


def _within(model: Model, genes: Array, room: Room, bound: Limits, like: Flight) -> _Tried | None:
    """A motion that the rotors can fly, made calmer until they can; None if never."""
    for _ in range(_TRIES):
        reference = path(room, genes)
        flight = expected(model, reference, like)
        if _can_fly(model, flight, bound):
            return _Tried(genes, reference, flight, -np.inf)
        genes = calmer(genes, _CALMER)
    return None


def _flyable(
    model: Model, best: list[_Tried], room: Room, bound: Limits, like: Flight
) -> tuple[_Tried, Simulated | None, str]:
    """The best motion, made calmer until a simulated vehicle flies it within its limits and near its reference.

    Where the simulation cannot say, or no calmer one does, the motion as it is, and why.
    """
    one, why = best[0], ""
    for k in range(_TRIES):
        try:
            sim = simulated(model, one.reference, bound)
        except InputError as error:
            return one, None, str(error)
        if sim is None:
            return one, None, "not simulated: that takes rotors, mass and inertia in the vehicle file; begin gently"
        away = sim.away(one.reference)
        why = f"in simulation it strays by {away:.2g} m from the reference" if not away <= _BESIDE else ""
        if sim.at_limit > _AT_LIMIT:
            why = f"in simulation a rotor is at its limit for {100 * sim.at_limit:.0f} % of the time"
        if not why:
            return one, sim, ""
        # The next best first, then calmer ones of it.
        next_best = best[k + 1] if k + 1 < len(best) else None
        made = next_best or _within(model, calmer(one.genes, _CALMER), room, bound, like)
        if made is None:
            break
        one = made
    return one, sim, why


def _last(found: Diagnosis) -> Observation:
    """The last of the flown flights alone."""
    o = found.search.observation
    return replace(o, samples=o.samples[-1:], transforms=o.transforms[-1:])


def _now(a: Asked) -> float:
    """Whether the odds pass already."""
    return float(abs(a.question.odds) >= AS_PROBABLE)


def _numbers(question: Question, gram: Gram, again: Gram, labels: Sequence[str]) -> list[Told]:
    out = []
    for label in labels:
        now, after, at = question.errors_after(gram, label)
        _, repeated, _ = question.errors_after(again, label)
        linear = question.first.fit.linear
        candidate = next(c for c in linear.columns if c.candidate.label == label).candidate
        vehicle = linear.observation.vehicle
        of = [_named(label, p, i) for p in candidate.form for i in range(p.count(vehicle))]
        names = tuple(of[k] for k in at)
        found = next(m.effect for m in question.first.members if m.candidate.label == label)
        size = np.abs(raw(found, places(candidate, vehicle)) - _absent(candidate, vehicle))[at]
        shares = tuple(np.divide(now, size, out=np.full(len(now), np.inf), where=size > 0))
        out.append(Told(label, None, None, None, names, tuple(now), tuple(repeated), tuple(after), shares))
    return out


def _named(label: str, parameter: Parameter, component: int) -> str:
    """A number of an effect for people: with its axis or tilt, and with its unit, where it has one."""
    which = "" if parameter.size == 1 else f" {'xyz'[component] if parameter.size == 3 else component}"
    return f"{label}.{parameter.name}{which}" + (f", {parameter.unit}" if parameter.unit != "-" else "")


def _absent(candidate: Candidate, vehicle: Vehicle) -> Array:
    """The numbers of no effect, in the order of the fitted ones."""
    return np.concatenate([candidate.cls.absent(vehicle, p) for p in candidate.form])


def _rotor_inputs(flight: Flight) -> Array:
    """What each rotor is asked for (n, rotors); (0, 0) where the vehicle is given a wrench."""
    prefix = "cmd_rotor_" if flight.has("cmd_rotor_0") else "rotor_"
    columns = [f"{prefix}{i}" for i in range(flight.numbered(prefix).shape[1])]
    return np.stack([flight.get(c)[:, 0] for c in columns], axis=1) if columns else np.zeros((0, 0))
