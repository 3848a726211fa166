"""Diagnosis: which named effects a model lacks on these flights, how sure that is, and what is left unexplained."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.comparing.statistics import Statistics
from infotraj.diagnosis import premises, refusal, selecting
from infotraj.diagnosis import search as searching
from infotraj.diagnosis.candidates import Candidate, candidates
from infotraj.diagnosis.fitting import Fit
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
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Diagnosis:
    """What was found. before, after: equation error of the model as given and with the supported effects.

    supported: names, one for each Supported effect and each Not separable group; model: with them added; members,
    errors_of: the fitted effects in it and their standard errors, in the model's order; whole: the fit of all that the
    search took; final: that of `model` (of all where nothing is supported).
    """

    findings: tuple[Finding, ...]
    supported: tuple[str, ...]
    unexplained: Unexplained
    refused: dict[str, str]
    before: Statistics
    after: Statistics
    model: Model
    errors_of: tuple[dict[str, Any], ...]
    samples: tuple[FlightSamples, ...]
    search: Search
    whole: Fit
    final: Fit

    @property
    def command_steps(self) -> int:
        """How many steps the commands were taken to make from row to row, at most; 1: they were held."""
        return max(command_steps(s.flight) for s in self.samples)

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
    known, hidden = candidates(catalog, vehicle, flights)
    held = held_members(model, flights[0])
    observation = observe(model, flights, start, stop)
    doubts = premises.doubts(model, flights, start, stop)
    known, hidden = premises.remaining(doubts, catalog, known, hidden)
    taken = {m.candidate.label for m in held}
    known = [c for c in known if c.label not in taken]

    def searched(observation: Observation, rng: np.random.Generator) -> tuple[Search, Fit]:
        search = searching.start_search(observation, held, known, rng, matters)
        return search, selecting.run(search, held) if known else search.fitted(held)

    search, whole = searched(observation, rng)
    if known and any(sparse(f, vehicle) for f in flights):
        between = between_rows(flights, vehicle, likeliest_steps(observation, held, known))
        other, found = searched(observe(model, between, start, stop), np.random.default_rng([seed, 1]))
        if fits_better((other.observation, found), (search.observation, whole)):
            flights, search, whole = between, other, found
    left = Unexplained(False, ()) if doubts else unexplained(search, whole, rng)
    refused = doubts or search.silent | refusal.unanswered(
        search.observation.model(whole.members), flights, start, stop
    )
    judge = Judge(search, whole, list(catalog), left, refused, rng)
    findings = judge.findings(hidden)
    supported, chosen = _supported(findings, whole, search)
    spreads = widening(left)
    if not doubts:
        named = {f.name for f in findings if f.verdict in CONFIDENT}
        labels = {m.candidate.label for m in whole.members if m.candidate.name in named} | judge.ordinary
        left = left.beside(withheld(search, whole, labels, judge.misfits, judge.chance, refused))
    # The model that is given is fitted as it is given: without what else the search had taken.
    final = search.fitted([*(m for m in whole.members if m.held), *chosen]) if chosen else whole
    labels = {m.candidate.label for m in (*held, *chosen)}
    added = [m for m in final.members if m.candidate.label in labels]
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
        refused,
        before,
        after,
        after_model,
        errors,
        search.observation.samples,
        search,
        whole,
        final,
    )


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
