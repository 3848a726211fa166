"""The verdict on every effect of the catalogue: of those in the fitted set, and of those that the search left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from infotraj.diagnosis.gates.refusal import axis_group
from infotraj.diagnosis.judge.evidence import Evidence, evidence_of_absent, left_by_set, little
from infotraj.diagnosis.judge.groups import Rival, rivals
from infotraj.diagnosis.judge.needed import SURE, Judged
from infotraj.diagnosis.judge.numbers import fitted_numbers, in_fit, values_of
from infotraj.diagnosis.judge.path import shows_on_path
from infotraj.diagnosis.judge.unexplained import Unexplained, more_stays
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.diagnosis.select.prior import OF_THE_LOG
from infotraj.diagnosis.select.search import Search
from infotraj.progress import reached

CONFIDENT = ("Supported", "Not separable")
MATTERS = 0.05  # rise of the squared error, in units of the floor, below which an effect does not matter
HALVES = float(np.log(2.0))  # the same, by half of one axis
_LIKELY = 0.5
_AS_WELL = 0.05  # of the error that a group's members leave: less is no reason to prefer one
_FORCE, _BIAS = "steady_force", "accelerometer_bias"
_WORSE = "flights that were not fitted are predicted worse with it, all of them"


@dataclass(frozen=True)
class Finding:
    """One effect: its verdict, group, evidence, and numbers where it was fitted. `reason`: why, in words; unsure: that
    is, that these numbers may be wrong, not only whether they are of an effect or of the file; of_file: they are the
    file's own error, and no question is open."""

    name: str
    verdict: str
    group: tuple[str, ...]
    evidence: Evidence | None
    parameters: dict[str, Any]
    standard_errors: dict[str, Any]
    reason: str = ""
    instances: tuple[dict[str, Any], ...] = ()
    instance_errors: tuple[dict[str, Any], ...] = ()
    unsure: bool = False
    of_file: bool = False

    @property
    def each(self) -> tuple[Finding, ...]:
        """The finding once for each instance, with that one's numbers and their standard errors, itself first."""
        pairs = zip(self.instances, self.instance_errors, strict=True)
        others = (replace(self, parameters=v, standard_errors=e) for v, e in pairs if v != self.parameters)
        return (self, *others)


_Alike = tuple[Member, dict[str, Any], Rival | None]  # a member of a group, its standard errors, and its fit


@dataclass(frozen=True)
class Judge:
    """What verdicts are drawn from: the search, the set of effects that predict, all that was judged for it, names of
    the catalogue, structure that is left, axes on which nothing can be said; faint: axes of torque of which less than
    half goes with the set's prediction, and that share, where what makes torques larger as a whole is asked about;
    as_ever: axes on which these flights leave no more of the healthy model than some healthy flight does."""

    search: Search
    whole: Fit
    judged: Sequence[Judged]
    order: tuple[str, ...]
    left: Unexplained
    refused: Mapping[str, str]
    matters: float
    rng: np.random.Generator
    faint: Mapping[str, float] = field(default_factory=dict)
    as_ever: frozenset[str] = frozenset()

    def findings(self, hidden: Mapping[str, str]) -> tuple[tuple[Finding, ...], dict[str, Rival]]:
        """One finding for each effect of the catalogue, in its order, and rivals that stand for a group, by name.

        hidden: what has no candidate, and why.
        """
        out: dict[str, Finding] = {}
        stand: dict[str, Rival] = {}
        each: dict[str, list[tuple[bool, dict[str, Any], dict[str, Any]]]] = {}
        # What stands in the place of two is told in the group in which it takes most off.
        count = max(sum(j.needed for j in self.judged), 1)
        for k, j in enumerate(sorted(self.judged, key=lambda j: -j.evidence.gain)):
            reached("naming", k, count)
            name = j.member.candidate.name
            if j.needed:
                each.setdefault(name, []).append((self._doubt(j)[0] is None, values_of(j.member), j.errors))
            for f, rival in self._of_member(j):
                old = out.get(f.name)
                if old is None or (old.verdict not in CONFIDENT and f.verdict in CONFIDENT):
                    out[f.name] = f
                    if rival is not None:
                        stand[f.name] = rival
        for m, errors in zip(self.whole.members, fitted_numbers(self.whole), strict=True):
            if m.held:
                name, reason = m.candidate.name, "in the model already"
                out.setdefault(name, Finding(name, "Not needed", (name,), None, values_of(m), errors, reason))
        for name, many in each.items():
            # Beside one that is named those that are only plausible are not.
            told = [x for x in many if x[0]] or many
            if len(told) > 1 and name in out:
                values, own = tuple(v for _, v, _ in told), tuple(e for _, _, e in told)
                out[name] = replace(out[name], instances=values, instance_errors=own)
        for name in self.order:
            if name not in out:
                absent = Finding(name, "Not testable here", (name,), None, {}, {}, hidden.get(name, ""))
                out[name] = absent if name in hidden else self._of_absent(name)
        return tuple(out[n] for n in self.order), stand

    def _of_member(self, j: Judged) -> list[tuple[Finding, Rival | None]]:
        m, errors, found = j.member, j.errors, j.evidence
        name, label = m.candidate.name, m.candidate.label
        verdict, reason = self._doubt(j)
        if verdict is not None:
            unsure = reason == self._faint(j)
            return [(Finding(name, verdict, (name,), found, values_of(m), errors, reason, unsure=unsure), None)]
        others = [r for r in rivals(self.search, self.whole, label, self.matters) if r.label.split()[0] != name]
        members: list[_Alike] = [(m, errors, None), *((*in_fit(r.fit, r.label, self.whole), r) for r in others)]
        members = self._simplest_first(members)
        findings = group_of([(x, own, found) for x, own, _ in members])
        return list(zip(findings, (r for *_, r in members), strict=True))

    def _simplest_first(self, members: list[_Alike]) -> list[_Alike]:
        """What predicts best beside the file as it is stands for the group; the simplest of those that do as well.

        A steady force that the path does not show comes after the bias of the accelerometer that shows it.
        """
        vehicle = self.search.observation.vehicle
        fits = {x[0].candidate.name: self.whole if x[2] is None else x[2].fit for x in members}
        felt = fits.keys() >= {_FORCE, _BIAS} and not shows_on_path(fits[_FORCE], fits[_BIAS])
        left = {id(x): left_by_set(self.whole if x[2] is None else x[2].fit).sum() for x in members}
        best = min(left.values())
        return sorted(
            members,
            key=lambda x: (
                left[id(x)] > best + _AS_WELL,
                felt and x[0].candidate.name == _FORCE,
                x[0].candidate.count(vehicle),
                len(x[0].candidate.cls.beside),  # what acts by itself is simpler than what needs another
                self.order.index(x[0].candidate.name),
            ),
        )

    def _doubt(self, j: Judged) -> tuple[str | None, str]:
        """Why an effect that was judged is not named with confidence: verdict and reason, (None, "") where it is."""
        e = j.evidence
        if e.rise < self.matters:
            return "Not needed", "real, but negligible"
        # Physics without a name is there in every second: what resembles it a little is sure, and predicts little.
        if not j.needed:
            return ("Not needed", _WORSE) if e.against else ("Plausible", little(e))
        # A clock is no further off where the file is, and what hardly any other number does is there in any case, an
        # effect's or the file's: what takes half of an error off with it is named.
        declared = j.member.candidate.cls.declared
        sure_of_number = declared is not None and (
            declared.kind in OF_THE_LOG or (declared.alone and self.search.observation.healthy is None)
        )
        least = _LIKELY if sure_of_number and e.gain >= HALVES else SURE
        if e.probability < least or e.selected < SURE:
            chance = f"{100 * e.probability:.0f} % probable, better on {100 * e.selected:.0f} % of the resamples"
            return "Plausible", f"{chance} of flights that were not fitted"
        faint = self._faint(j) or self._usual(e)
        if faint:
            return "Plausible", faint
        beside = "" if e.gain >= HALVES else more_stays(self.left, e.falls, e.by_axis)
        return ("Plausible", beside) if beside else (None, "")

    def _usual(self, e: Evidence) -> str:
        """That an effect takes too little off where these flights leave more than every healthy one; empty if not.

        Of few healthy flights no one knows what all of them may differ by: an error as large as one of theirs needs no
        change to explain it.
        """
        on = [a for a, x in e.falls.items() if a in self.as_ever and x > 0.0]
        if not on or sum(x for a, x in e.falls.items() if a not in self.as_ever and x > 0.0) >= TELLS:
            return ""
        most = max(on, key=lambda a: e.falls[a])
        return f"the healthy model leaves no more on {axis_group(most) or most} here than on some healthy flight"

    def _faint(self, j: Judged) -> str:
        """That what changes a predicted torque as a whole, or goes with what is fed back, is told by a torque of which
        less than half goes with that prediction, or is another moment of inertia altogether there; empty if not.

        Beside a moment that no name explains, and that the rotors hold against, a larger inertia makes their torque as
        small as what turns the vehicle. So do errors of what a regression is made of (Fuller 1987). What they take off
        the factor is left, and goes with the rate that a controller feeds back, as a damping does.
        """
        if not (self.faint and j.member.candidate.cls.like_commands):
            return ""
        most = max(j.evidence.falls, key=lambda a: j.evidence.falls[a], default="")
        unsure = "what is not predicted may make it so"
        if most in self.faint:
            share = f"only {100 * self.faint[most]:.0f} % goes with the prediction"
            return f"it shows most in the torque about {most[1]}, of which {share}: {unsure}"
        o = self.search.observation
        inertia = o.model([j.member]).body_law.inertia
        times = np.diag(inertia) / np.diag(o.vehicle.inertia_matrix()) if inertia is not None else np.ones(3)
        far = {a: float(times["xyz".index(a[1])]) for a in self.faint}
        axis = max(far, key=lambda a: abs(np.log(far[a])))
        if abs(np.log(far[axis])) < HALVES:
            return ""
        share = f"only {100 * self.faint[axis]:.0f} % of the torque there goes with the prediction"
        return f"the inertia about {axis[1]} would be {far[axis]:.2g} times the file's; {share}: {unsure}"

    def _of_absent(self, name: str) -> Finding:
        linear = self.whole.linear
        mine = [i for i, c in enumerate(linear.choices) if c.label.split()[0] == name and np.isfinite(c.price)]
        if not mine:
            return Finding(name, "Not needed", (name,), None, {}, {}, "in the model already")
        scores = self.whole.scorer.scores([(*self.whole.chosen, i) for i in mine])
        best = mine[int(np.argmax(scores))]
        candidate = next(c for c in self.search.known if c.label == linear.choices[best].label)
        silent = self._shows_nothing(best, candidate)
        if silent:
            return Finding(name, "Not testable here", (name,), None, {}, {}, silent)
        found = evidence_of_absent(self.whole, best, self.rng) if np.isfinite(max(scores)) else None
        worse = found is not None and found.gain < TELLS and found.against
        likely = found is not None and found.probability > _LIKELY and found.rise >= self.matters and not worse
        if found is None:
            reason = "with it numbers would end at a bound"
        elif worse:
            reason = _WORSE
        else:
            reason = little(found) if found.gain < TELLS else f"{100 * found.probability:.0f} % probable"
        reason = self.search.barred.get(candidate.label, reason)
        return Finding(name, "Plausible" if likely else "Not needed", (name,), found, {}, {}, reason)

    def _shows_nothing(self, choice: int, candidate: Candidate) -> str:
        """Why an effect of usual size would not be seen on these flights; empty where it would."""
        columns = [1 + c for c in self.whole.linear.choices[choice].columns]
        gram = self.whole.linear.sums.total
        told = max(gram[c, c] for c in columns)
        inside = {x.candidate.name for x in self.whole.members}
        if candidate.cls.beside and not inside & set(candidate.cls.beside):
            return f"it acts beside {' or '.join(candidate.cls.beside)} only"
        refused = f" (not {', '.join(self.refused)}: {next(iter(self.refused.values()))})" if self.refused else ""
        return "" if told > 1.0 else f"these flights do not excite it: one of usual size would not show{refused}"


def group_of(members: Sequence[tuple[Member, dict[str, Any], Evidence]]) -> list[Finding]:
    """Findings of effects with their errors and evidence: of one alone that it is missing, of several that one is."""
    names = tuple(dict.fromkeys(m.candidate.name for m, *_ in members))
    alone = len(names) == 1
    reason = "" if alone else f"these flights cannot tell {' from '.join(names)}"
    return [
        Finding(m.candidate.name, "Supported" if alone else "Not separable", names, found, values_of(m), errors, reason)
        for m, errors, found in members
    ]


def named(findings: Sequence[Finding]) -> tuple[str, ...]:
    """Names of Supported effects and of each group's simplest member."""
    names: list[str] = []
    for f in findings:
        name = f.name if f.verdict == "Supported" else f.group[0] if f.verdict == "Not separable" else None
        if name is not None and name not in names:
            names.append(name)
    return tuple(names)
