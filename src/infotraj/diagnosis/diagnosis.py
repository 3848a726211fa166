"""Diagnosis: which named effects a model lacks on these flights, how sure that is, and what is left unexplained."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from infotraj.comparing.statistics import Statistics
from infotraj.diagnosis import premises, refusal
from infotraj.diagnosis import search as searching
from infotraj.diagnosis.allowance import without_tolerances
from infotraj.diagnosis.candidates import Candidate, candidates, places
from infotraj.diagnosis.constancy import MOST, inconstancy
from infotraj.diagnosis.evidence import Evidence, evidence, standard_errors
from infotraj.diagnosis.fitting import Fit, beyond_bounds
from infotraj.diagnosis.groups import Group, group
from infotraj.diagnosis.null import null_gains
from infotraj.diagnosis.observation import Member, Observation
from infotraj.diagnosis.residual import FlightSamples, flight_samples
from infotraj.diagnosis.search import MATTERS, SIGNIFICANCE, Search, spread
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.subsets import SubsetSearch
from infotraj.diagnosis.sums import Sums
from infotraj.diagnosis.tolerance import tolerated
from infotraj.diagnosis.unexplained import Unexplained, unexplained
from infotraj.diagnosis.whitened import blocks, noise_model
from infotraj.effects import Effect, catalogue
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_STEADY = 0.8  # share of the resamples that must keep an effect
_WIDEN = 1.7  # times the standard errors where structure is left: by as much they were too small in simulation
_CLEARER = 5.0  # times the structure that is left on its own axis: an effect that explains less may be part of that
_CLEAR = 3.0  # times the structure that is left on any axis of force or torque: the same


@dataclass(frozen=True)
class Finding:
    """One effect: its verdict, group, evidence, and numbers where it was fitted. `reason`: why, in words."""

    name: str
    verdict: str
    group: tuple[str, ...]
    evidence: Evidence | None
    parameters: dict[str, Any]
    standard_errors: dict[str, Any]
    reason: str = ""
    instances: tuple[dict[str, Any], ...] = ()


@dataclass(frozen=True)
class Diagnosis:
    """What was found. before, after: equation error of the model as given and with the supported effects.

    supported: names, one for each Supported effect and each Not separable group; model: with them added; members,
    errors_of: the fitted effects in it and their standard errors, in the model's order.
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
    return Observation(model.vehicle, samples, noise, blocks(samples))


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
    known, hidden = candidates(catalog, vehicle, flights)
    held = held_members(model, flights[0])
    observation = observe(model, flights, start, stop)
    doubts = premises.doubts(model, flights, start, stop)
    known, hidden = premises.remaining(doubts, catalog, known, hidden)
    taken = {m.candidate.label for m in held}
    search = searching.start_search(observation, held, [c for c in known if c.label not in taken], rng, matters)
    whole = searching.run(search, held) if search.known else search.fitted(held)
    # What tolerances explain stays in the model in which the others are judged: it is in the flights.
    ordinary = tolerated(search, whole)
    left = Unexplained(False, ()) if doubts else unexplained(search, whole, rng)
    refused = doubts or search.silent | refusal.unanswered(
        search.observation.model(whole.members), flights, start, stop
    )
    findings = _findings(search, whole, list(catalog), known, hidden, ordinary, left, refused, rng)
    supported, chosen = _supported(findings, whole, search)
    # The model that is given is fitted as it is given: without what else the search had taken.
    final = search.fitted([*(m for m in whole.members if m.held), *chosen]) if chosen else whole
    labels = {m.candidate.label for m in (*held, *chosen)}
    added = [m for m in final.members if m.candidate.label in labels]
    after_model = Model(vehicle, [m.effect for m in added]) if chosen else model
    before = refusal.errors(model, flights, start, stop)
    after = refusal.errors(after_model, flights, start, stop) if chosen else before
    widen = _WIDEN if left.found else 1.0
    numbers = zip(final.members, fitted_numbers(final, vehicle, widen, spread(search, final)), strict=True)
    numbers = list(numbers)
    errors = tuple(e for m, e in numbers if m.candidate.label in labels) if chosen else ()
    findings = _as_given(findings, numbers)
    return Diagnosis(
        findings, supported, left, refused, before, after, after_model, errors, observation.samples, search, whole
    )


def _as_given(findings: tuple[Finding, ...], numbers: list) -> tuple[Finding, ...]:
    """The findings with the numbers of the model that is given, where they are in it."""
    given: dict[str, list[tuple[dict, dict]]] = {}
    for m, errors in numbers:
        given.setdefault(m.candidate.name, []).append((_values(m), errors))
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


def _findings(search, whole, order, known, hidden, ordinary, left, refused, rng) -> tuple[Finding, ...]:
    sums, found = search.linear(whole.members)
    sums = without_tolerances(sums, found, search.tolerance)
    subsets = SubsetSearch(sums, found)
    singles = [(i,) for i in range(len(found.choices))]
    chance = float(np.quantile(null_gains(sums, found, singles, rng), SIGNIFICANCE)) if singles else 0.0
    wrong = beyond_bounds(whole, search.observation.vehicle)
    vehicle = search.observation.vehicle
    widen = _WIDEN if left.found else 1.0
    errors = dict(
        zip(
            [m.candidate.label for m in whole.members],
            _errors(whole, vehicle, widen, spread(search, whole)),
            strict=True,
        )
    )
    out: dict[str, Finding] = {}
    reported = [m for m in whole.members if m.candidate.label not in ordinary]
    for m in reported:
        columns = found.members[[x.candidate.label for x in whole.members].index(m.candidate.label)]
        made = _of_member(search, whole, m, order, chance, left, refused, wrong, errors, rng, sums, columns)
        for f in made:
            if f.name not in out or (
                out[f.name].verdict != "Supported" and f.verdict in ("Supported", "Not separable")
            ):
                out[f.name] = f
    instances: dict[str, list[dict]] = {}
    for m in reported:
        instances.setdefault(m.candidate.name, []).append(_values(m))
    for name, values in instances.items():
        if len(values) > 1 and name in out:
            out[name] = replace(out[name], instances=tuple(values))
    for name in order:
        if name in out:
            continue
        if name in hidden:
            out[name] = Finding(name, "Not testable here", (name,), None, {}, {}, hidden[name])
            continue
        small = [m for m in whole.members if m.candidate.name == name and m.candidate.label in ordinary]
        if small:
            out[name] = _of_tolerated(search, whole, small[0], chance, errors, rng)
        else:
            out[name] = _of_absent(search, subsets, sums, found, name, chance, bool(ordinary), rng)
    return tuple(out[n] for n in order)


def _of_member(search, whole, m, order, chance, left, refused, wrong, errors, rng, sums, columns) -> list[Finding]:
    rest = [x for x in whole.members if x.candidate.label != m.candidate.label]
    out = search.fitted(rest)
    apart = group(search, whole, m, rng, order) if not m.held else Group((m,), (whole,), ())
    e = evidence(
        searching.heldout_error(out),
        searching.heldout_error(whole),
        whole.sums.windows,
        whole.sums.axes,
        whole.sums.fold,
        whole.sums.flight,
        chance,
        rng,
        list(apart.rivals),
        (out.plain - whole.plain) / np.maximum(whole.plain, 1e-300),
    )
    names = tuple(x.candidate.name for x in apart.members)
    reason = ""
    axis = refusal.axis_group(e.axis, refused)
    if m.held:
        verdict, reason = "Not needed", "in the model already"
    elif m.candidate.label in wrong:
        verdict, reason = "Plausible", wrong[m.candidate.label]
    elif axis in refused:
        verdict, reason = "Plausible", refused[axis]
    elif e.rise < search.matters or e.gain < chance:
        verdict, reason = "Not needed", "real, but negligible" if e.gain >= chance else "no gain"
    elif e.ci95[1] >= 0 or e.selected < _STEADY:
        verdict, reason = "Plausible", f"kept in {e.selected:.0%} of the resamples only"
    elif (hides := _overshadowed(e, left)) is not None:
        verdict, reason = "Plausible", hides
    elif (varies := inconstancy(sums, columns, out.cost - whole.cost)) > MOST:
        verdict = "Plausible"
        reason = f"its numbers differ between parts of the flights, which would gain another {varies:.0%}"
    else:
        verdict = "Supported" if len(names) == 1 else "Not separable"
    if verdict == "Plausible":
        # Where nothing is named with confidence there is no group to be confident about.
        names = (m.candidate.name,)
    label = m.candidate.label
    if verdict != "Not separable":
        return [Finding(m.candidate.name, verdict, names, e, _values(m), _numbers(m, errors[label]), reason)]
    reason = _apart(names)
    made = []
    for other, fitted in zip(apart.members, apart.fits, strict=True):
        own = dict(
            zip(
                [x.candidate.label for x in fitted.members],
                _errors(fitted, search.observation.vehicle, _WIDEN if left.found else 1.0, spread(search, fitted)),
                strict=True,
            )
        )
        made.append(
            Finding(
                other.candidate.name,
                verdict,
                names,
                e if other is m else _in_place(search, out, fitted, chance, rng),
                _values(other),
                _numbers(other, own[other.candidate.label]),
                reason,
            )
        )
    return made


def _in_place(search: Search, out: Fit, fitted: Fit, chance: float, rng) -> Evidence:
    s = fitted.sums
    return evidence(
        searching.heldout_error(out),
        searching.heldout_error(fitted),
        s.windows,
        s.axes,
        s.fold,
        s.flight,
        chance,
        rng,
        plain=(out.plain - fitted.plain) / np.maximum(fitted.plain, 1e-300),
    )


def _overshadowed(e: Evidence, left: Unexplained) -> str | None:
    """The reason where what is left unexplained is not small beside what this effect explains."""
    for s in left.axes:
        own = e.by_axis.get(s.axis, 0.0)
        part = own > 0.5 * e.rise and own < _CLEARER * s.rise
        if part or (s.axis[0] in "ft" and e.rise < _CLEAR * s.rise):
            return (
                f"structured error is left on {s.axis} (rise {s.rise:.2g}) beside the {e.rise:.2g} that this explains"
            )
    return None


def _of_tolerated(search, whole, m, chance, errors, rng) -> Finding:
    out = search.fitted([x for x in whole.members if x.candidate.label != m.candidate.label])
    e = _in_place(search, out, whole, chance, rng)
    numbers = _numbers(m, errors[m.candidate.label])
    reason = "real, but ordinary tolerances of the vehicle file explain it"
    return Finding(m.candidate.name, "Not needed", (m.candidate.name,), e, _values(m), numbers, reason)


def _of_absent(search, subsets: SubsetSearch, sums: Sums, found: Sensitivities, name, chance, ordinary, rng) -> Finding:
    mine = [i for i, c in enumerate(found.choices) if c.candidate.name == name]
    if not mine:
        return Finding(name, "Not needed", (name,), None, {}, {}, "in the model already")
    none = subsets.score([()])[0]
    base = none.held_out(sums)
    best = max(subsets.score([(i,) for i in mine]), key=lambda s: s.gain)
    error = best.held_out(sums) if np.isfinite(best.gain) else base
    plain = searching.plain_rise(sums.plain, none, best, none) if np.isfinite(best.gain) else None
    e = evidence(base, error, sums.windows, sums.axes, sums.fold, sums.flight, chance, rng, plain=plain)
    if ordinary and e.gain >= chance:
        # What made the tolerated effects unnecessary makes this one unnecessary too.
        return Finding(
            name, "Not needed", (name,), e, {}, {}, "ordinary tolerances of the vehicle file explain as much"
        )
    windows = np.maximum(sums.windows.sum(axis=1), 1)
    plain_gram = sums.plain.gram / np.maximum(none.plain(sums.plain), 1e-300)[:, None, None]
    rises = [sums.gram.sum(axis=1) / windows[:, None, None], plain_gram]
    usual = max(_usual_rise(gram, found, i) for gram in rises for i in mine)
    if usual < search.matters:
        silent = next(iter(search.silent.values()), None)
        reason = silent or (
            f"these flights do not excite it: at its usual size it would raise the error by {usual:.2g} of the floor"
        )
        return Finding(name, "Not testable here", (name,), e, {}, {}, reason)
    ended = [why for label, why in search.at_bound.items() if label.split()[0] == name]
    if e.gain < chance:
        return Finding(name, "Not needed", (name,), e, {}, {}, ended[0] if ended else "no gain")
    if ended:
        return Finding(name, "Plausible", (name,), e, {}, {}, ended[0])
    if e.rise < search.matters:
        return Finding(name, "Not needed", (name,), e, {}, {}, "real, but negligible")
    return Finding(name, "Plausible", (name,), e, {}, {}, "some gain beside the supported effects")


def _usual_rise(gram: Array, found: Sensitivities, index: int) -> float:
    """Rise that an effect of usual size would make, the members' numbers refitted (power).

    gram (axes, p, p): products of columns per unit of the floor.
    """
    own, new = list(found.of_members), list(found.choices[index].columns)
    total = gram.sum(axis=0)
    best = 0.0
    for c in new:
        column = np.zeros(total.shape[0])
        column[c] = 1.0
        if own:
            block = total[np.ix_(own, own)]
            column[own] = -np.linalg.solve(
                block + 1e-9 * np.diag(np.diag(block)) + 1e-12 * np.eye(len(own)), total[own, c]
            )
        rise = np.einsum("aij,i,j->a", gram, column, column)
        best = max(best, float(rise.max()))
    return best


def _values(m: Member) -> dict[str, Any]:
    """What is fixed and what is fitted of a member, other forms of the effect left out."""
    wanted = {*dict(m.candidate.fixed), *(p.name for p in m.candidate.form)}
    return {k: v for k, v in m.effect.values.items() if k in wanted}


def fitted_numbers(made: Fit, vehicle: Vehicle, widen: float = 1.0, more: Array | float = 0.0) -> list[dict[str, Any]]:
    """Standard errors of every member of a fit by parameter, times `widen`; more (p,): variance added, usual sizes."""
    return [_numbers(m, e) for m, e in zip(made.members, _errors(made, vehicle, widen, more), strict=True)]


def _errors(made: Fit, vehicle: Vehicle, widen: float, more: Array | float) -> list[Array]:
    """Standard errors of every member's numbers, in their units, times `widen`."""
    gram, right, _ = made.sums.total()
    all_of_them = np.sqrt((widen * standard_errors(gram, right)) ** 2 + more)
    out, place = [], 0
    for m in made.members:
        at = places(m.candidate, vehicle)
        out.append(all_of_them[place : place + len(at)] * np.abs([p.scale for p in at]))
        place += len(at)
    return out


def _numbers(m: Member, values: Array) -> dict[str, Any]:
    """Numbers of a member by parameter, a list where the parameter is one."""
    out, place = {}, 0
    for p in m.candidate.form:
        size = np.size(getattr(m.effect, p.name))
        part = [float(v) for v in values[place : place + size]]
        out[p.name] = part[0] if p.size == 1 else part
        place += size
    return out


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


def _apart(names: tuple[str, ...]) -> str:
    return f"these flights cannot tell {' from '.join(names)}"
