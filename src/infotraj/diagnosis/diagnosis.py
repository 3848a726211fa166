"""Diagnosis: which named effects a model lacks on these flights, how sure that is, and what is left unexplained."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from infotraj.arguments import AnyPath
from infotraj.checking.acceptance import accepted_in
from infotraj.comparing.equation_error import AXES
from infotraj.comparing.statistics import Statistics, statistics
from infotraj.diagnosis.gates import agreement, premises, refusal
from infotraj.diagnosis.gates.accelerometer import unshaken
from infotraj.diagnosis.gates.doubt import Doubt, as_accepted, of_residual, once, refused_axes, with_mixed
from infotraj.diagnosis.gates.impossible_body import impossible_body
from infotraj.diagnosis.gates.level import as_level
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.gates.saturation import saturated
from infotraj.diagnosis.judge.as_ever import as_ever, largest
from infotraj.diagnosis.judge.deciding import Asked, decided
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.numbers import FileNumber, beside_what_stays, file_numbers, fitted_numbers
from infotraj.diagnosis.judge.products import free_products, products
from infotraj.diagnosis.judge.unexplained import Unexplained
from infotraj.diagnosis.judge.verdicts import CONFIDENT, MATTERS, Finding, named
from infotraj.diagnosis.lengths import AGAIN, HEALTHY, PARTS, against
from infotraj.diagnosis.linear.candidates import Candidate, candidates, places
from infotraj.diagnosis.linear.change import Change, changes
from infotraj.diagnosis.linear.healthy import Healthy
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.measure.residual import FlightSamples, flight_samples
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.bounds import beyond_bounds
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.learned import around_fit, around_usual, learned, of_a_day, straight
from infotraj.diagnosis.select.prior import file_only
from infotraj.diagnosis.select.reading import as_commanded, as_healthy, as_read
from infotraj.diagnosis.select.search import Search
from infotraj.diagnosis.select.swinging import swung
from infotraj.dynamics.inputs import for_vehicle
from infotraj.effects import Effect, catalogue
from infotraj.effects.channels import from_velocity
from infotraj.errors import InputError, problem
from infotraj.flight import Flight, command_steps
from infotraj.models import Model
from infotraj.progress import parts, pieces, reached, step, within
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_CLEAR = 1.0  # s before and after the ground, which pushes and turns a vehicle: no part of what is compared
_TORQUES = frozenset(a for a in AXES if a[0] == "t")
_STEPS = 3  # that who waits is told of


@dataclass(frozen=True)
class Diagnosis:
    """What was found. before, after: equation error of the model as given and with the supported effects.

    doubts: why axes cannot be judged, and what a reader must know; refused: those axes fx .. tz, with the reason;
    supported: names, one for each Supported effect and each Not separable group; model: with them added; errors_of: the
    standard errors of its effects, in the model's order; file: what the vehicle file should say; at_bound: labels of
    effects whose numbers stopped at a physical bound, and how; coherence (6,): share of what was measured that
    goes with the model as given; faint: axes of torque of which less than half goes with the new one, and that share;
    whole: the fit of the effects that predict; final:
    that of the model that is given; beside: labels of its effects that are no finding and correct the file, for the
    named ones to hold; start, stop: s, the part of every flight that was used; healthy: what they were held against in
    place of the model; usual (6,): the largest error that it leaves on any of its own flights, NaN where that is not
    known; of_day (6,): the error that stays where the healthy numbers are as the day of these flights may have them;
    by_file (6,): share of the error that what corrects the file takes off; as_ever: axes of the residual on which
    what is left, of force or torque the error as well, is no more than on some healthy flight.
    """

    findings: tuple[Finding, ...]
    supported: tuple[str, ...]
    unexplained: Unexplained
    doubts: tuple[Doubt, ...]
    refused: dict[str, str]
    coherence: Array
    faint: dict[str, float]
    before: Statistics
    after: Statistics
    model: Model
    errors_of: tuple[dict[str, Any], ...]
    file: tuple[FileNumber, ...]
    at_bound: dict[str, str]
    search: Search
    whole: Fit
    final: Fit
    beside: tuple[str, ...] = ()
    start: float | None = None
    stop: float | None = None
    healthy: Healthy | None = None
    usual: Array = field(default_factory=lambda: _unknown())
    of_day: Array = field(default_factory=lambda: _unknown())
    by_file: Array = field(default_factory=lambda: _unknown())
    as_ever: frozenset[str] = frozenset()

    @property
    def samples(self) -> tuple[FlightSamples, ...]:
        """The flights as they were read."""
        return self.search.observation.samples

    @property
    def command_steps(self) -> int:
        """How many steps the commands were taken to make from row to row, at most; 1: they were held."""
        return max(command_steps(s.flight) for s in self.samples)

    @property
    def by_velocity(self) -> bool:
        """Whether forces of any flight are told from its velocity, though it has an accelerometer."""
        return any(from_velocity(s.flight) for s in self.samples)

    @property
    def judged(self) -> bool:
        """Whether any axis of force or torque could be judged."""
        return len(self.refused) < len(AXES)

    @property
    def accepted(self) -> list[dict[str, Any]]:
        """Findings about the flights and doubts that the user overruled, for JSON and provenance."""
        return accepted_in([s.flight for s in self.samples]) + [d.as_dict() for d in self.doubts if d.accepted]

    def healthy_numbers(self, f: Finding) -> dict[str, Any] | None:
        """The healthy numbers of an effect that was fitted, and their standard errors, by parameter."""
        c, vehicle = self._as_fitted(f), self.search.observation.vehicle
        if c is None or self.healthy is None:
            return None
        return self.healthy.said(c, places(c, vehicle), vehicle)

    def changes(self, f: Finding) -> tuple[Change, ...]:
        """By how much the numbers of an effect that was fitted differ from the healthy ones."""
        c, vehicle = self._as_fitted(f), self.search.observation.vehicle
        if c is None or self.healthy is None:
            return ()
        at, now = places(c, vehicle), c.at({p.name: f.parameters[p.name] for p in c.form})
        known = np.isfinite(self.healthy.errors(c.label, at)).tolist()
        return changes(c, now, self.healthy.values(c, vehicle), f.standard_errors, known, at, vehicle)

    def _as_fitted(self, f: Finding) -> Candidate | None:
        """The candidate whose numbers a finding has, where it is held against healthy flights."""
        if self.healthy is None or not f.parameters:
            return None
        own = [c for c in self.search.known if c.name == f.name]
        return next((c for c in own if all(f.parameters.get(k) == v for k, v in c.fixed)), None)

    def finding(self, name: str) -> Finding:
        """The finding of that name."""
        return next(f for f in self.findings if f.name == name)


def diagnose(
    model: Model,
    flights: Sequence[Flight],
    *,
    effects_from: AnyPath | Iterable[AnyPath] = (),
    matters: float = MATTERS,
    seed: int = 0,
    start: float | None = None,
    stop: float | None = None,
    reference: Sequence[Flight] | Healthy = (),
) -> Diagnosis:
    """Which effects of the catalogue `model` lacks on these flights.

    reference: healthy flights of the same vehicle, or what `learn` made of them; what is asked then is which effects
    differ from them.
    effects_from: files or folders with the user's own effects. matters: rise of the squared error, in units of the
    floor, below which an effect is negligible. start, stop: s, the part of every flight to use. InputError where a
    flight cannot be used.
    """
    step(1, _STEPS, "reading the flights")
    catalog = catalogue(effects_from)
    vehicle = model.vehicle
    flights = [for_vehicle(f, vehicle) for f in flights]
    healthy: Healthy | None = None
    notes: tuple[Doubt, ...] = ()
    if isinstance(reference, Healthy):
        healthy = reference
    else:
        both = [*flights, *(for_vehicle(f, vehicle) for f in reference)]
        every, notes = unshaken(model, both, start, stop, together=len(both) > len(flights))
        flights, usual_flights = every[: len(flights)], every[len(flights) :]
        if usual_flights:
            step(1, _STEPS, "healthy flights")
            parts(against(flights, usual_flights))
            with within(HEALTHY):
                healthy = learn(model, usual_flights, effects_from=effects_from, start=start, stop=stop)
            reached("first columns")
    held = held_members(model, flights[0]) if healthy is None else ()
    seen = flights if healthy is None else as_healthy([as_level(f) for f in flights], healthy.flights, vehicle)
    known, hidden = candidates(catalog, vehicle, seen)
    if healthy is not None:
        known, hidden = healthy.shown(known, hidden)
    search_on = partial(_searched, held=held, names=catalog, known=known, hidden=hidden)
    doubts = (*notes, *premises.doubts(model, flights, start, stop))
    step(2, _STEPS, "searching")
    observation = replace(observe(model, seen, start, stop, _CLEAR if healthy is not None else 0.0), healthy=healthy)
    model = model if healthy is None else observation.model([])
    if healthy is not None:
        # Where the healthy flights themselves did not follow their model, no fit makes the axes follow it.
        usual = _balanced(model, seen, start, stop) if healthy.balance else frozenset()
        observation = _in_balance(observation, healthy.balance | observation.balance | usual)
    # Where healthy flights were learned, who waits was told of all of it before.
    planned = healthy is not None and not isinstance(reference, Healthy)
    search, whole, why_not = search_on(observation, doubts, told=not planned)
    if healthy is not None and search.known:
        late_balance = _balanced(search.observation.model(straight(whole)), seen, start, stop)
        if not late_balance <= observation.balance:
            observation = _in_balance(observation, observation.balance | late_balance)
            search, whole, why_not = search_on(observation, doubts, told=True)
    if healthy is None:
        # What a fitted model still does not say was no ground to fit it on: it is left out, and the rest judged anew.
        told_of = refused_axes(doubts).keys()
        fitted = search.observation.model(straight(whole))
        reached("fitted model")
        read = search.observation.flights
        after_all = refusal.unanswered(fitted, read, start, stop, known=told_of, given=model)
        late = [d for d in as_accepted(after_all, read) if not refused_axes(doubts).keys() >= set(d.axes)]
        doubts = once((*doubts, *late))
        if search.known and any(d.counts for d in late):
            pieces("searching again", AGAIN)
            reached("searching again")
            search, whole, why_not = search_on(observation, doubts, like=whole)
    doubts = (*doubts, *saturated(flights, vehicle), *impossible_body(vehicle))
    refused = with_mixed(refused_axes(doubts), observation.samples)
    sideways = [a for a in AXES[:2] if "v" + a[1] in observation.ignored and a not in refused]
    refused = {**refused, **dict.fromkeys(sideways, "no attitude: the vehicle is taken as level")}
    step(3, _STEPS, "judging")
    reached("structure")
    rng = np.random.default_rng([seed, 1])
    of_inertia = free_products(search, whole)
    o = search.observation
    of_healthy = _of_healthy(model, healthy, o, start, stop)
    usual_on = as_ever(largest(model, o.samples, o.balance), of_healthy)
    asked = Asked(search, tuple(catalog), why_not, refused, matters, seed, rng, start, stop, of_inertia, usual_on)
    findings, told, made, others = decided(asked, whole)
    reached("errors")
    final, supported = made.fit, named(findings)
    into = [m for m in final.members if not m.held]
    chosen = [m for m in into if m.candidate.name in supported or m.candidate.label in made.beside]
    added = [*(m for m in final.members if m.held), *chosen] if chosen else list(held)
    after_model = observation.model(added) if chosen else model
    # Both with commands as they were read: how they were made between rows is no part of a model.
    read = search.observation.flights
    as_given = refusal.compared(model, read, start, stop)
    before = statistics(as_given)
    as_found = refusal.compared(after_model, read, start, stop) if chosen else as_given
    after = statistics(as_found) if chosen else before
    doubts = agreement.still_doubtful(doubts, as_found, vehicle)
    # With the healthy numbers as they are a change would be as sure as if they were known.
    surer = final if healthy is None or not set(final.labels) <= set(told.labels) else told
    numbers = dict(zip((m.candidate.label for m in surer.members), fitted_numbers(surer, told), strict=True))
    errors = tuple(numbers.get(m.candidate.label, {}) for m in added) if chosen else ()
    sure = {f.name for f in findings if f.verdict in CONFIDENT}
    unsure = {f.name: f"{f.name}: {f.reason}" for f in findings if f.unsure}
    own = {f.name for f in findings if f.of_file}
    beside = told if of_inertia is None or of_inertia.candidate in told.known else of_inertia.beside(told)
    stays = asked.left(beside)
    of_file = file_numbers(beside, sure, unsure, asked.faint(told), own, others, stays) if search.known else ()
    leaves = _unknown() if healthy is None else _usual(model, healthy, start, stop)
    return Diagnosis(
        findings,
        supported,
        stays,
        doubts,
        refused,
        refusal.coherence(as_given),
        refusal.hardly_predicted(as_found, as_given) if healthy is None else {},
        before,
        after,
        after_model,
        errors,
        beside_what_stays(of_file, _stays(after), vehicle),
        beyond_bounds(added, vehicle),
        search,
        told,
        final,
        made.beside,
        start,
        stop,
        healthy,
        leaves,
        _unknown() if healthy is None or not search.known else _of_day(search.observation, told, chosen, start, stop),
        _unknown() if healthy is not None else _by_file(search, made.beside, added, before, after, start, stop),
        _no_more(as_ever(largest(after_model, o.samples, o.balance), of_healthy), after, leaves),
    )


def _unknown() -> Array:
    """What is not known of any axis."""
    return np.full(len(AXES), np.nan)


def _by_file(
    search: Search,
    beside: Sequence[str],
    added: Sequence[Member],
    before: Statistics,
    after: Statistics,
    start: float | None,
    stop: float | None,
) -> Array:
    """Share (6,) of the error that what corrects the file takes off. beside: labels of what corrects it."""
    o, flights = search.observation, search.observation.flights
    parts = [[m for m in added if (m.candidate.label in beside) == of_file and not m.held] for of_file in (True, False)]
    if not all(parts):
        found = [before if parts[1] else after, before if parts[0] else after]
    else:
        held = [m for m in added if m.held]
        try:
            found = [refusal.errors(o.model([*held, *part]), flights, start, stop) for part in parts]
        except InputError:  # half of a model may be no body
            return _unknown()
    alone, without = (x.rmse for x in found)
    return share_taken(before.rmse, alone, without, after.rmse)


def share_taken(before: Array, alone: Array, without: Array, after: Array) -> Array:
    """The share of an error that one of two parts takes off, alone and beside the other, whichever is less: what the
    other takes as well is none of it.

    Errors of neither part, of it alone, of the other alone, and of both.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(1.0 - np.maximum(alone / before, after / without))


def learn(
    model: Model,
    reference: Sequence[Flight],
    *,
    effects_from: AnyPath | Iterable[AnyPath] = (),
    start: float | None = None,
    stop: float | None = None,
) -> Healthy:
    """What healthy flights say of every number of the model. InputError where nothing can be judged on them.

    start, stop: s, the part of every flight to use.
    """
    catalog = catalogue(effects_from)
    flights = [for_vehicle(f, model.vehicle) for f in reference]
    held = held_members(model, flights[0])
    seen = [as_level(f) for f in flights]
    known, hidden = candidates(catalog, model.vehicle, seen)
    doubts = premises.doubts(model, flights, start, stop)
    observation = observe(model, seen, start, stop, _CLEAR)
    search_on = partial(_searched, held=held, names=catalog, known=known, hidden=hidden)
    balance = observation.balance
    if balance:
        balance |= _balanced(model, seen, start, stop)
    else:
        # Whether torques follow the commands is asked of the fitted model: a file may be wrong by a lag.
        search, whole, _ = search_on(observation, doubts)
        seen = _as_read(seen, search)
        balance = _balanced(search.observation.model(straight(whole)), seen, start, stop) if search.known else balance
    if balance and (observation.balance or balance == _TORQUES):
        # Of what is not predicted nothing can be identified: it is only said what is usual.
        every = [*known, *file_only(model.vehicle, known, seen)]
        usual = linearised(replace(observation, balance=balance), held, every)
        return learned(around_usual(usual, every), seen, 1.0)
    if balance:
        search, whole, _ = search_on(replace(observation, balance=balance), doubts)
    if not search.known:
        why = next(iter(refused_axes(doubts).values()), "no effect can be tested on them")
        raise InputError(problem(f"the healthy flights: {why}", "flights that can be judged", "Choose others."))
    reached("numbers")
    numbers = around_fit(whole, [*search.known, *products(search.known)])
    return learned(numbers, _as_read(seen, search), overdispersion(whole)[0])


def _as_read(flights: Sequence[Flight], search: Search) -> list[Flight]:
    """The flights of a search, whole, with commands as it read them."""
    return [as_read(f, s.flight) for f, s in zip(flights, search.observation.samples, strict=True)]


def _usual(model: Model, healthy: Healthy, start: float | None, stop: float | None) -> Array:
    """The largest error that the healthy model leaves on any healthy flight, (6,)."""
    made = refusal.compared(model, healthy.flights, start, stop)
    return np.fmax.reduce([statistics([e]).rmse for e in made])


def _of_healthy(
    model: Model, healthy: Healthy | None, asked: Observation, start: float | None, stop: float | None
) -> dict[str, Array]:
    """The largest error that the healthy model leaves on any healthy flight, by axis of the residual, predicted as the
    flights that are asked about are."""
    if healthy is None:
        return {}
    made = (flight_samples(model, f, start, stop, _CLEAR) for f in healthy.flights)
    return largest(model, (replace(s, prepared=s.prepared.turning(asked.turned)) for s in made), asked.balance)


def _no_more(now: frozenset[str], after: Statistics, usual: Array) -> frozenset[str]:
    """Those axes of the residual on which the error of force or torque that is told is no larger than usual, too."""
    more = {a for a, x, y in zip(AXES, after.rmse, usual, strict=True) if x > y}
    return frozenset(a for a in now if refusal.axis_group(a) not in more)


def _of_day(
    observation: Observation, told: Fit, named: Sequence[Member], start: float | None, stop: float | None
) -> Array:
    """The error that stays beside what is named where the healthy numbers are as that day may have them, (6,)."""
    try:
        with np.errstate(all="ignore"):  # numbers far from any flight may overflow
            model = observation.model(of_a_day(told, {m.candidate.label for m in named}))
            return statistics(refusal.compared(model, observation.flights, start, stop)).rmse
    except (InputError, np.linalg.LinAlgError):  # numbers of no body
        return _unknown()


def _stays(after: Statistics) -> float:
    """What varies of the force along z (N) beyond the floor, in a model that is given."""
    varies = float(after.rmse[2] ** 2 - after.bias[2] ** 2 - after.floor[2] ** 2)
    return float(np.sqrt(varies)) if varies > 0.0 else 0.0


def _in_balance(observation: Observation, balance: frozenset[str]) -> Observation:
    """The same with these axes held against the healthy flights by their balance alone."""
    healthy = observation.healthy
    scatter = dict(zip(healthy.owners, healthy.scatter.tolist(), strict=True)) if healthy is not None else {}
    return replace(observation, balance=balance, scatter=scatter if balance else {})


def _balanced(model: Model, flights: Sequence[Flight], start: float | None, stop: float | None) -> frozenset[str]:
    """Axes of torque of which a model says too little, but for the balance over seconds of what stays level."""
    doubts = refusal.unanswered(model, flights, start, stop, refusal.HALF_EXPLAINED)
    return frozenset(a for d in doubts for a in d.axes if a[0] == "t")


def _searched(
    observation: Observation,
    doubts: Sequence[Doubt],
    *,
    held: tuple[Member, ...],
    names: Iterable[str],
    known: list[Candidate],
    hidden: dict[str, str],
    like: Fit | None = None,
    told: bool = False,
) -> tuple[Search, Fit, dict[str, str]]:
    """The search on the axes that can be judged, its best set, and why the other effects have no candidate.

    told: who waits is told how long a diagnosis with this search will take.
    """
    taken = {m.candidate.label for m in held}
    left_to, why_not = premises.remaining(doubts, names, known, hidden)
    left_to = [c for c in left_to if c.label not in taken]
    if left_to:
        left_to += [c for c in file_only(observation.vehicle, known, observation.flights) if c.label not in taken]
        if observation.healthy is not None:
            # A load beside the planes of symmetry changes them, and no name says so.
            left_to += observation.healthy.shown(products(left_to), {})[0]
        ignored = of_residual(with_mixed(refused_axes(doubts), observation.samples))
        observation = observation.without_axes(ignored)
    if like is not None and {c.label for c in left_to} != {c.label for c in like.known}:
        like = None
    if like is not None and observation.turned != like.linear.observation.turned:
        like = None  # its columns are of forces beside turns that are not believed any more
    if like is not None:
        first = like.linear.without_axes(observation.ignored)
    else:
        before = (*held, *_healthy_members(observation, known))
        read = as_commanded if observation.healthy is None else linearised
        first = swung(read(observation, before, left_to), left_to)
    search = Search(first.observation, tuple(left_to), held)
    if told:
        parts(PARTS)
    return search, search.best(first, like), why_not


def _healthy_members(observation: Observation, known: Sequence[Candidate]) -> tuple[Member, ...]:
    """The effects of the healthy model, as candidates that may change."""
    if observation.healthy is None:
        return ()
    file = file_only(observation.vehicle, known, observation.flights)
    every = {c.label: c for c in (*known, *file, *products(known))}
    return tuple(Member(every[k], e) for k, e in observation.healthy.effects.items() if k in every)


def held_members(model: Model, flight: Flight) -> tuple[Member, ...]:
    """The effects that a model has already: fitted along, never taken out."""
    return tuple(_held(e, flight, model.vehicle) for e in model.effects)


def _held(effect: Effect, flight: Flight, vehicle: Vehicle) -> Member:
    fixed = tuple((p.name, int(getattr(effect, p.name))) for p in effect.parameters if p.index)
    form = tuple(p for p in effect.parameters if not p.index and getattr(effect, p.name) is not None)
    # Of several forms the one that the model has, whatever these flights would be given.
    own = tuple(p for p in form if p.optional and np.any(getattr(effect, p.name)))
    chosen = own or tuple(p for p in type(effect).form(vehicle, flight) if p in form)
    return Member(Candidate(type(effect), chosen or form, fixed), effect, held=True)
