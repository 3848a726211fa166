"""The verdict on every effect of the catalogue: of those in the fitted model, and of those that the search left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infotraj.diagnosis import refusal
from infotraj.diagnosis import search as searching
from infotraj.diagnosis.allowance import without_tolerances
from infotraj.diagnosis.constancy import MOST, inconstancy
from infotraj.diagnosis.evidence import Evidence, evidence
from infotraj.diagnosis.fitting import Fit, beyond_bounds
from infotraj.diagnosis.formula import Formulas, Misfit
from infotraj.diagnosis.groups import Group, group
from infotraj.diagnosis.null import null_gains
from infotraj.diagnosis.numbers import by_parameter, errors_of, values_of
from infotraj.diagnosis.observation import Member
from infotraj.diagnosis.search import SIGNIFICANCE, Search, spread
from infotraj.diagnosis.sensitivities import Sensitivities
from infotraj.diagnosis.subsets import SubsetSearch
from infotraj.diagnosis.sums import Sums
from infotraj.diagnosis.tolerance import tolerated
from infotraj.diagnosis.unexplained import Unexplained
from infotraj.rotations import Array

CONFIDENT = ("Supported", "Not separable")
_STEADY = 0.8  # share of the resamples that must keep an effect
_WIDEN = 1.7  # times the standard errors where structure is left: by as much they were too small in simulation
_CLEARER = 5.0  # times the structure that is left on its own axis: an effect that explains less may be part of that
_CLEAR = 3.0  # times the structure that is left on any axis of force or torque: the same
_FORM = 0.003  # of the squared error that an empirical formula explains: it is hardly exact to better than 5 %
_EXACT = 0.0003  # the same of mechanics and measurement: what is logged is not exact to better than 2 %
_EMPIRICAL = ("actuators", "thrust", "wrench")


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


def widening(left: Unexplained) -> float:
    """By how much standard errors are too small where structure is left."""
    return _WIDEN if left.found else 1.0


@dataclass
class Judge:
    """What verdicts are drawn from.

    whole: the fitted model; order: names of the catalogue; left: structure that it leaves; refused: axes on which
    nothing can be said, and why; ordinary: labels of what tolerances explain; chance: gain that an absent effect gets;
    sums, found: around the fitted model, tolerances taken off.
    """

    search: Search
    whole: Fit
    order: list[str]
    left: Unexplained
    refused: Mapping[str, str]
    rng: np.random.Generator

    def __post_init__(self) -> None:
        sums, self.found = self.search.linear(self.whole.members)
        # What tolerances explain stays in the model in which the others are judged: it is in the flights.
        self.ordinary = tolerated(self.search, self.whole)
        self.sums: Sums = without_tolerances(sums, self.found, self.search.tolerance)
        self.subsets = SubsetSearch(self.sums, self.found)
        singles = [(i,) for i in range(len(self.found.choices))]
        gains = null_gains(self.sums, self.found, singles, self.rng) if singles else np.zeros(1)
        self.chance = float(np.quantile(gains, SIGNIFICANCE))
        self._absent = [c for choice in self.found.choices for c in choice.columns]
        self._errors: dict[int, list[Array]] = {}
        self._wrong = beyond_bounds(self.whole.members, self.search.observation.vehicle)
        self._formulas: Formulas | None = None
        self.misfits: dict[str, Misfit] = {}

    def findings(self, hidden: Mapping[str, str]) -> tuple[Finding, ...]:
        """One finding for each effect of the catalogue, in its order; hidden: what has no candidate, and why."""
        reported = [m for m in self.whole.members if m.candidate.label not in self.ordinary]
        out: dict[str, Finding] = {}
        for m in reported:
            for f in self._of_member(m):
                if f.name not in out or (out[f.name].verdict != "Supported" and f.verdict in CONFIDENT):
                    out[f.name] = f
        out |= self._within_form(reported, out)
        out |= self._beside_misfits(out)
        instances: dict[str, list[dict]] = {}
        for m in reported:
            instances.setdefault(m.candidate.name, []).append(values_of(m))
        for name, values in instances.items():
            if len(values) > 1 and name in out:
                out[name] = replace(out[name], instances=tuple(values))
        small = {m.candidate.name: m for m in self.whole.members if m.candidate.label in self.ordinary}
        for name in self.order:
            if name in out:
                continue
            if name in hidden:
                out[name] = Finding(name, "Not testable here", (name,), None, {}, {}, hidden[name])
            else:
                out[name] = self._of_tolerated(small[name]) if name in small else self._of_absent(name)
        return tuple(out[n] for n in self.order)

    def _numbers(self, made: Fit, m: Member) -> dict[str, Any]:
        """Standard errors of a member of a fit."""
        if id(made) not in self._errors:
            vehicle = self.search.observation.vehicle
            self._errors[id(made)] = errors_of(made, vehicle, widening(self.left), spread(self.search, made))
        every = self._errors[id(made)]
        labels = [x.candidate.label for x in made.members]
        return by_parameter(m, every[labels.index(m.candidate.label)])

    def _against(self, out: Fit, with_it: Fit, rivals: Sequence[Array] = ()) -> Evidence:
        """Evidence for what one fit has and the other has not."""
        s = with_it.sums
        plain = (out.plain - with_it.plain) / np.maximum(with_it.plain, 1e-300)
        before, after = searching.heldout_error(out), searching.heldout_error(with_it)
        return evidence(before, after, s.windows, s.axes, s.fold, s.flight, self.chance, self.rng, list(rivals), plain)

    def _without(self, m: Member) -> Fit:
        return self.search.fitted([x for x in self.whole.members if x.candidate.label != m.candidate.label])

    def _of_member(self, m: Member) -> list[Finding]:
        search, whole = self.search, self.whole
        out = self._without(m)
        apart = group(search, whole, m, self.rng, self.order, self.chance) if not m.held else Group((m,), (whole,), ())
        e = self._against(out, whole, apart.rivals)
        verdict, reason = self._doubt(m, e, out.cost - whole.cost)
        names = tuple(x.candidate.name for x in apart.members)
        if verdict is None and len(names) > 1:
            reason = f"these flights cannot tell {' from '.join(names)}"
            return [
                Finding(
                    other.candidate.name,
                    "Not separable",
                    names,
                    e if other is m else self._against(out, fitted),
                    values_of(other),
                    self._numbers(fitted, other),
                    "; ".join([reason, *self._ends(fitted, other)]),
                )
                for other, fitted in zip(apart.members, apart.fits, strict=True)
            ]
        # Where nothing is named with confidence there is no group to be confident about.
        own = (m.candidate.name,) if verdict in (None, "Plausible") else names
        numbers = self._numbers(whole, m)
        return [Finding(m.candidate.name, verdict or "Supported", own, e, values_of(m), numbers, reason)]

    def _ends(self, made: Fit, m: Member) -> list[str]:
        """That a member's numbers end at a bound in this fit; empty where they do not."""
        ended = beyond_bounds(made.members, self.search.observation.vehicle)
        return [ended[m.candidate.label]] if m.candidate.label in ended else []

    def _doubt(self, m: Member, e: Evidence, explained: float) -> tuple[str | None, str]:
        """Why a member of the model is not named with confidence: verdict and reason, (None, "") where it is.

        explained: squared error that it takes away.
        """
        axis = refusal.axis_group(e.axis)
        if m.held:
            return "Not needed", "in the model already"
        if m.candidate.label in self._wrong:
            return "Plausible", self._wrong[m.candidate.label]
        if axis in self.refused:
            return "Plausible", self.refused[axis]
        if e.gain < self.chance:
            return "Not needed", "no gain"
        if e.rise < self.search.matters:
            return "Not needed", "real, but negligible"
        if (misfit := self._misfit(m, e, explained)) is not None:
            return "Plausible", f"its numbers change {misfit.how}: that gains {_percent(misfit.share)} on top"
        if e.ci95[1] >= 0 or e.selected < _STEADY:
            return "Plausible", f"kept in {e.selected:.0%} of the resamples only"
        if (hides := _overshadowed(e, self.left)) is not None:
            return "Plausible", hides
        place = [x.candidate.label for x in self.whole.members].index(m.candidate.label)
        # Where structure is left that can be predicted, it is no drift.
        drifts = not any(e.by_axis.get(s.axis, 0.0) > 0.2 * e.rise for s in self.left.axes)
        absent = self._absent if drifts else []
        theta, mine = searching.departure(self.whole, {m.candidate.label}, self.search.observation.vehicle)
        size = float(np.max(np.abs(theta[mine])))
        varies = inconstancy(self.sums, self.found.members[place], size, explained, absent)
        if varies > MOST:
            how = "between parts of the flights"
            self.misfits[m.candidate.label] = Misfit(how, e.axis, min(varies, 1.0) * e.rise, varies)
            return "Plausible", f"its numbers change {how}: their own would gain {_percent(varies)} on top"
        return None, ""

    def _misfit(self, m: Member, e: Evidence, explained: float) -> Misfit | None:
        if self._formulas is None:
            self._formulas = Formulas(self.search, self.whole, self.rng)
        found = self._formulas.misfit(m, explained, e.rise)
        if found is not None:
            self.misfits[m.candidate.label] = found
        return found

    def _acts_on_refused(self, mine: Sequence[int]) -> list[str]:
        """Axes that cannot be judged on which these choices (of `found`) act."""
        base, labels = self.search.base, {self.found.choices[i].candidate.label for i in mine}
        columns = [1 + i for c in base.choices if c.candidate.label in labels for i in c.columns]
        acts: dict[str, float] = {}
        for s, flight in zip(self.search.observation.samples, base.joint, strict=True):
            for channel, x in zip(s.channels, flight, strict=True):
                for i, axis in enumerate(channel.axes):
                    size = np.max(np.mean(x[:, i, columns] ** 2, axis=0), initial=0.0) / max(
                        np.mean(x[:, i, 0] ** 2), 1e-300
                    )
                    group = refusal.axis_group(axis) or axis
                    acts[group] = max(acts.get(group, 0.0), float(size))
        most = max(acts.values(), default=0.0)
        return [a for a in self.refused if acts.get(a, 0.0) > 1e-4 * most]

    def _within_form(self, reported: Sequence[Member], out: Mapping[str, Finding]) -> dict[str, Finding]:
        """Findings that may be no more than what another effect's formula is off by."""
        changed: dict[str, Finding] = {}
        acts = {m.candidate.label: self._acts(m) for m in reported}
        for m in reported:
            f = out[m.candidate.name]
            if f.verdict not in CONFIDENT:
                continue
            for other in reported:
                by = out[other.candidate.name]
                if other.candidate.name in f.group or by.verdict not in CONFIDENT:
                    continue
                share = _FORM if other.candidate.cls.place in _EMPIRICAL else _EXACT
                if _dwarfed(f.evidence, acts[other.candidate.label], self.search.matters, share):
                    reason = f"{by.name} explains so much more that what its formula is off by may be as large"
                    changed |= {
                        n: replace(out[n], verdict="Plausible", group=(n,), reason=reason)
                        for n in f.group
                        if out[n].group == f.group
                    }
        return changed

    def _acts(self, m: Member) -> dict[str, float]:
        """Mean square of what a member predicts on every axis, as a rise: in units of the floor, per window."""
        theta, mine = searching.departure(self.whole, {m.candidate.label}, self.search.observation.vehicle)
        sums = self.whole.sums
        gram = sums.gram[:, :, mine][..., mine].sum(axis=1)
        size = np.einsum("aij,i,j->a", gram, theta[mine], theta[mine]) / np.maximum(sums.windows.sum(axis=1), 1)
        return dict(zip(sums.axes, map(float, size), strict=True))

    def _beside_misfits(self, out: Mapping[str, Finding]) -> dict[str, Finding]:
        """Findings beside an effect whose formula does not hold, which may be part of the same cause.

        They are on the same axis, or explain hardly more than what that formula is known to miss.
        """
        changed: dict[str, Finding] = {}
        for f in out.values():
            for label, misfit in self.misfits.items():
                name = label.split()[0]
                if f.verdict not in CONFIDENT or f.name == name:
                    continue
                if _part_of(f.evidence, out[name].evidence) or f.evidence.gain < _CLEAR * misfit.gain:
                    reason = f"it may be part of what {name} takes up, whose formula does not hold"
                    changed[f.name] = replace(f, verdict="Plausible", group=(f.name,), reason=reason)
        return changed

    def _of_tolerated(self, m: Member) -> Finding:
        e = self._against(self._without(m), self.whole)
        reason = "real, but ordinary tolerances of the vehicle file explain it"
        numbers = self._numbers(self.whole, m)
        return Finding(m.candidate.name, "Not needed", (m.candidate.name,), e, values_of(m), numbers, reason)

    def _of_absent(self, name: str) -> Finding:
        sums, found, search = self.sums, self.found, self.search
        mine = [i for i, c in enumerate(found.choices) if c.candidate.name == name]
        if not mine:
            return Finding(name, "Not needed", (name,), None, {}, {}, "in the model already")
        none = self.subsets.score([()])[0]
        base = none.held_out(sums)
        best = max(self.subsets.score([(i,) for i in mine]), key=lambda s: s.gain)
        error = best.held_out(sums) if np.isfinite(best.gain) else base
        plain = searching.plain_rise(sums.plain, none, best, none) if np.isfinite(best.gain) else None
        e = evidence(base, error, sums.windows, sums.axes, sums.fold, sums.flight, self.chance, self.rng, plain=plain)

        def verdict(verdict: str, reason: str) -> Finding:
            return Finding(name, verdict, (name,), e, {}, {}, reason)

        if self.ordinary and e.gain >= self.chance:
            # What made the tolerated effects unnecessary makes this one unnecessary too.
            return verdict("Not needed", "ordinary tolerances of the vehicle file explain as much")
        windows = np.maximum(sums.windows.sum(axis=1), 1)
        plain_gram = sums.plain.gram / np.maximum(none.plain(sums.plain), 1e-300)[:, None, None]
        rises = [sums.gram.sum(axis=1) / windows[:, None, None], plain_gram]
        usual = max(_usual_rise(gram, found, i) for gram in rises for i in mine)
        beside = next(c.cls.beside for c in search.known if c.name == name)
        if usual < search.matters and beside and not {m.candidate.name for m in self.whole.members} & {*beside}:
            return verdict(
                "Not testable here", f"it acts beside {' or '.join(beside)} only, and none of them is missing"
            )
        if usual < search.matters:
            acts = self._acts_on_refused(mine)
            where = f" on the axes that can be judged (not {', '.join(acts)})" if acts else ""
            reason = f"these flights do not excite it{where}: at its usual size it would raise the error by"
            why = f"; {self.refused[acts[0]]}" if acts else ""
            return verdict("Not testable here", f"{reason} {usual:.2g} of the floor{why}")
        ended = [why for label, why in search.at_bound.items() if label.split()[0] == name]
        if e.gain < self.chance:
            return verdict("Not needed", ended[0] if ended else "no gain")
        if ended:
            return verdict("Plausible", ended[0])
        if e.rise < search.matters:
            return verdict("Not needed", "real, but negligible")
        return verdict("Plausible", "some gain beside the supported effects")


def _part_of(e: Evidence, other: Evidence) -> bool:
    """Whether an effect may be part of what another takes up, on the axis where that one shows most."""
    own = e.by_axis.get(other.axis, 0.0)
    return own > 0.5 * e.rise and own < _CLEAR * other.rise


def _overshadowed(e: Evidence, left: Unexplained) -> str | None:
    """The reason where what is left unexplained is not small beside what this effect explains."""
    for s in left.axes:
        own = e.by_axis.get(s.axis, 0.0)
        part = own > 0.5 * e.rise and own < _CLEARER * s.rise
        anywhere = refusal.axis_group(s.axis) is not None and s.share > 0
        if part or (anywhere and e.rise < _CLEAR * s.rise):
            return (
                f"structured error is left on {s.axis} (rise {s.rise:.2g}) beside the {e.rise:.2g} that this explains"
            )
    return None


def _percent(share: float) -> str:
    return f"{share:.0%} of what it explains" if share < 10 else "more than it explains"


def _dwarfed(e: Evidence, acts: Mapping[str, float], matters: float, share: float) -> bool:
    """Whether another effect does so much more on every axis on which this one matters.

    acts: what that one predicts, as a rise on every axis; not what is lost without it, where others make up for it.
    """
    axes = [a for a, rise in e.by_axis.items() if rise >= matters]
    return bool(axes) and all(e.by_axis[a] < share * acts.get(a, 0.0) for a in axes)


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
