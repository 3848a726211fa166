"""Diagnosis: which named effects a model lacks on these flights, how sure that is, and what is left unexplained."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.checking.acceptance import accepted_codes, accepted_in
from infotraj.comparing.equation_error import AXES
from infotraj.comparing.statistics import Statistics
from infotraj.diagnosis import premises, refusal, selecting
from infotraj.diagnosis import search as searching
from infotraj.diagnosis.candidates import Candidate, candidates
from infotraj.diagnosis.doubt import Doubt, as_accepted, of_residual, once, refused_axes, with_mixed
from infotraj.diagnosis.fitting import Fit, beyond_bounds
from infotraj.diagnosis.numbers import fitted_numbers, values_of
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.residual import FlightSamples, flight_samples
from infotraj.diagnosis.search import MATTERS, Search, spread
from infotraj.diagnosis.sparse_commands import between_rows, fits_better, likeliest_steps, sparse
from infotraj.diagnosis.unexplained import Unexplained, unexplained
from infotraj.diagnosis.verdicts import CONFIDENT, Finding, Judge, widening
from infotraj.diagnosis.whitened import blocks, noise_model
from infotraj.diagnosis.withheld import withheld
from infotraj.dynamics.inputs import for_vehicle
from infotraj.effects import Effect, catalogue
from infotraj.errors import InputError, problem
from infotraj.flight import Flight, command_steps
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_SEARCHES = 2  # the second without the axes that the first could not explain


@dataclass(frozen=True)
class Diagnosis:
    """What was found. before, after: equation error of the model as given and with the supported effects.

    doubts: why axes cannot be judged, and what a reader must know; refused: those axes fx .. tz, with the reason;
    supported: names, one for each Supported effect and each Not separable group; model: with them added; members,
    errors_of: the fitted effects in it and their standard errors, in the model's order; at_bound: labels of those whose
    numbers stopped at a physical bound, and how; coherence (6,): share of what was measured that goes with the model as
    given; whole: the fit of all that the search took; final: that of `model` (of all where nothing is supported).
    """

    findings: tuple[Finding, ...]
    supported: tuple[str, ...]
    unexplained: Unexplained
    doubts: tuple[Doubt, ...]
    refused: dict[str, str]
    coherence: Array
    before: Statistics
    after: Statistics
    model: Model
    errors_of: tuple[dict[str, Any], ...]
    at_bound: dict[str, str]
    samples: tuple[FlightSamples, ...]
    search: Search
    whole: Fit
    final: Fit

    @property
    def command_steps(self) -> int:
        """How many steps the commands were taken to make from row to row, at most; 1: they were held."""
        return max(command_steps(s.flight) for s in self.samples)

    @property
    def judged(self) -> bool:
        """Whether any axis of force or torque could be judged."""
        return len(self.refused) < len(AXES)

    @property
    def accepted(self) -> list[dict[str, Any]]:
        """Findings about the flights and doubts that the user overruled, for JSON and provenance."""
        return accepted_in([s.flight for s in self.samples]) + [d.as_dict() for d in self.doubts if d.accepted]

    def finding(self, name: str) -> Finding:
        """The finding of that name."""
        return next(f for f in self.findings if f.name == name)


def observe(
    model: Model, flights: Sequence[Flight], start: float | None = None, stop: float | None = None
) -> Observation:
    """The flights as samples with their first noise model, that of the residual as it is.

    InputError where a flight has no usable sample on any channel.
    """
    samples = tuple(flight_samples(model, f, start, stop) for f in flights)
    for s in samples:
        if not any(c.name in ("force", "velocity", "rate") for c in s.channels):
            left = ", ".join(f"{v} {k}" for k, v in s.left_out.items() if v)
            why = "; ".join(f"{k}: {v}" for k, v in s.reasons.items())
            raise InputError(
                problem(
                    f"{s.flight.meta.get('source', 'flight')}: nothing to compare ({left}; {why})",
                    "a flight in the air with commands and measured motion",
                    "Leave it out.",
                )
            )
    noise = noise_model(samples, [s.residual(model) for s in samples])
    step = max(premises.command_step(f, model.vehicle) for f in flights)
    return Observation(model.vehicle, samples, noise, blocks(samples), command_step=step)


def diagnose(
    model: Model,
    flights: Sequence[Flight],
    *,
    effects_from: Iterable[str | Path] = (),
    matters: float = MATTERS,
    seed: int = 0,
    start: float | None = None,
    stop: float | None = None,
) -> Diagnosis:
    """Which effects of the catalogue `model` lacks on these flights.

    effects_from: files or folders with the user's own effects. matters: rise of the squared error, in units of the
    floor, below which an effect is negligible. start, stop: s, the part of every flight to use. InputError where a
    flight cannot be used.
    """
    rng = np.random.default_rng(seed)
    catalog = catalogue(effects_from)
    vehicle = model.vehicle
    flights = [for_vehicle(f, vehicle) for f in flights]
    held = held_members(model, flights[0])
    known, hidden = candidates(catalog, vehicle, flights)
    taken = {m.candidate.label for m in held}
    doubts = premises.doubts(model, flights, start, stop)

    overruled = frozenset.intersection(*(accepted_codes(f) for f in flights))
    trusted = of_residual(AXES) if "axis_unexplained" in overruled else frozenset()

    def searched(flights: Sequence[Flight], absent: list[Candidate], rng: np.random.Generator) -> tuple[Search, Fit]:
        observation = observe(model, flights, start, stop)
        if absent:
            ignored = of_residual(with_mixed(refused_axes(doubts), observation.samples))
            observation = observation.without_axes(ignored)
        search = searching.start_search(observation, held, absent, rng, matters, trusted)
        return search, selecting.run(search, held) if absent else search.fitted(held)

    for _ in range(_SEARCHES):
        left_to, why_not = premises.remaining(doubts, catalog, known, hidden)
        left_to = [c for c in left_to if c.label not in taken]
        used, (search, whole) = flights, searched(flights, left_to, rng)
        if left_to and any(sparse(f, vehicle) for f in flights):
            between = between_rows(
                flights, vehicle, likeliest_steps(observe(model, flights, start, stop), held, left_to)
            )
            other, found = searched(between, left_to, np.random.default_rng([seed, 1]))
            if fits_better((other.observation, found), (search.observation, whole)):
                used, search, whole = between, other, found
        if not left_to:
            break
        doubts = once((*doubts, *as_accepted(search.silent, flights)))
        # What a fitted model still does not say was no ground to fit it on: it is left out, and the rest judged anew.
        after_all = refusal.unanswered(search.observation.model(whole.members), used, start, stop)
        late = [d for d in as_accepted(after_all, flights) if not refused_axes(doubts).keys() >= set(d.axes)]
        doubts = once((*doubts, *late))
        if not any(d.counts for d in late):
            break
    flights, hidden, known = used, why_not, left_to
    refused = with_mixed(refused_axes(doubts), search.observation.samples)
    left = unexplained(search, whole, rng) if known else Unexplained(False, ())
    judge = Judge(search, whole, list(catalog), left, refused, rng)
    findings = judge.findings(hidden)
    supported, chosen = _supported(findings, whole, search)
    while ended := _ended(search, whole, chosen):
        findings = _not_at_a_bound(findings, ended)
        supported, chosen = _supported(findings, whole, search)
    spreads = widening(left)
    if known:
        named = {f.name for f in findings if f.verdict in CONFIDENT}
        labels = {m.candidate.label for m in whole.members if m.candidate.name in named} | judge.ordinary
        left = left.beside(withheld(search, whole, labels, judge.misfits, judge.chance, refused))
    # The model that is given is fitted as it is given: without what else the search had taken.
    final = search.fitted([*(m for m in whole.members if m.held), *chosen]) if chosen else whole
    labels = {m.candidate.label for m in (*held, *chosen)}
    added = [m for m in final.members if m.candidate.label in labels] if chosen else list(held)
    after_model = Model(vehicle, [m.effect for m in added]) if chosen else model
    before = refusal.errors(model, flights, start, stop)
    after = refusal.errors(after_model, flights, start, stop) if chosen else before
    errors = fitted_numbers(final, vehicle, spreads, spread(search, final))
    numbers = zip(final.members, errors, strict=True)
    numbers = list(numbers)
    errors = tuple(e for m, e in numbers if m.candidate.label in labels) if chosen else ()
    findings = _as_given(findings, numbers)
    return Diagnosis(
        findings,
        supported,
        left,
        doubts,
        refused,
        refusal.coherence(model, flights, start, stop),
        before,
        after,
        after_model,
        errors,
        beyond_bounds(added, vehicle),
        search.observation.samples,
        search,
        whole,
        final,
    )


def _ended(search: Search, whole: Fit, chosen: Sequence[Member]) -> dict[str, str]:
    """Labels of what ends at a physical bound in the model that is given, without what else the search had taken."""
    if not chosen:
        return {}
    final = search.fitted([*(m for m in whole.members if m.held), *chosen])
    labels = {m.candidate.label for m in chosen}
    ended = beyond_bounds(final.members, search.observation.vehicle)
    return {label: reason for label, reason in ended.items() if label in labels}


def _not_at_a_bound(findings: Sequence[Finding], ended: dict[str, str]) -> tuple[Finding, ...]:
    """The findings; those whose numbers end at a bound, and the groups that they stand for, are Plausible at most."""
    why = {label.split()[0]: reason for label, reason in ended.items()}
    out = []
    for f in findings:
        reason = next((why[n] for n in (f.name, *f.group[:1]) if n in why), None)
        if reason is not None and f.verdict in CONFIDENT:
            f = replace(f, verdict="Plausible", group=(f.name,), reason=reason)
        out.append(f)
    return tuple(out)


def _as_given(findings: tuple[Finding, ...], numbers: list) -> tuple[Finding, ...]:
    """The findings with the numbers of the model that is given, where they are in it."""
    given: dict[str, list[tuple[dict, dict]]] = {}
    for m, errors in numbers:
        given.setdefault(m.candidate.name, []).append((values_of(m), errors))
    out = []
    for f in findings:
        mine = given.get(f.name, []) if f.verdict in ("Supported", "Not separable") else []
        same = [
            pair for pair in mine if all(pair[0].get(k) == v for k, v in f.parameters.items() if isinstance(v, int))
        ]
        if same:
            f = replace(f, parameters=same[0][0], standard_errors=same[0][1])
        if len(mine) > 1 and f.instances:
            f = replace(f, instances=tuple(values for values, _ in mine))
        out.append(f)
    return tuple(out)


def held_members(model: Model, flight: Flight) -> tuple[Member, ...]:
    """The effects that a model has already: fitted along, never taken out."""
    return tuple(_held(e, flight, model.vehicle) for e in model.effects)


def _held(effect: Effect, flight: Flight, vehicle: Vehicle) -> Member:
    fixed = tuple((p.name, int(getattr(effect, p.name))) for p in effect.parameters if p.index)
    form = tuple(p for p in effect.parameters if not p.index and getattr(effect, p.name) is not None)
    chosen = tuple(p for p in type(effect).form(vehicle, flight) if p in form)
    return Member(Candidate(type(effect), chosen or form, fixed), effect, held=True)


def _supported(findings: Sequence[Finding], whole: Fit, search: Search) -> tuple[tuple[str, ...], list[Member]]:
    """Names of Supported effects and of each group's simplest member, and the members to add."""
    names: list[str] = []
    for f in findings:
        name = f.name if f.verdict == "Supported" else f.group[0] if f.verdict == "Not separable" else None
        if name is not None and name not in names:
            names.append(name)
    added: list[Member] = []
    held = {m.candidate.name for m in whole.members if m.held}
    names = [n for n in names if n not in held]
    for f in findings:
        if f.name in names:
            own = [m for m in whole.members if m.candidate.name == f.name]
            if own:
                added += own
            else:
                choices = [c for c in search.known if c.name == f.name]
                fixed = {k: f.parameters[k] for k, _ in choices[0].fixed}
                candidate = next(c for c in choices if dict(c.fixed) == fixed)
                added.append(Member(candidate, candidate.cls(**f.parameters)))
    return tuple(names), added
