"""Which effects are missing: the set that predicts best beside a file as wrong as it is, fitted, and questioned again.

One linearisation is not enough: a large offset leaves a second-order rest that recruits other effects. So the model is
made linear again around what was found (Gauss and Newton), file numbers included, until the set and its numbers settle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.linear.observation import Member, Observation
from infotraj.diagnosis.noise.spectra import binned, spectra
from infotraj.diagnosis.select.around import Linear, linearised
from infotraj.diagnosis.select.bounds import beyond_bounds, parts_beyond
from infotraj.diagnosis.select.choosing import searched
from infotraj.diagnosis.select.fit import LOOSE, Fit
from infotraj.diagnosis.select.prior import Scales, is_file_number
from infotraj.diagnosis.select.scaling import scaled
from infotraj.progress import pieces, reached

_ROUNDS = 5
_SETTLED = 1.0  # weighted squared error by which a last step may still fall
_FAR = 0.1  # of the error, by which it may still fall where rounds ran out: with more the numbers are not found yet
_HALVES = 5
_CHEAP = 6  # steps with the columns that there are, for one that makes them anew
_ALIKE = 0.1  # of what a step promised may be promised again beside columns that are as good as new ones
_CONTRACTS = 0.8  # of what a step promised may be promised again: with more the columns are not those of the place
_EXPECTED = 1.2  # times the error that the linear model says of a step: with more it is taken by half


@dataclass
class Search:
    """The state of a search: flights, candidates, and what it did (`trail`), for the verbose output.

    barred: labels of candidates whose numbers would end at a physical bound, and of what.
    """

    observation: Observation
    known: tuple[Candidate, ...]
    held: tuple[Member, ...]
    trail: list[str] = field(default_factory=list)
    barred: dict[str, str] = field(default_factory=dict)

    def best(self, now: Linear, like: Fit | None = None) -> Fit:
        """The most probable set of effects, fitted. now: where it begins; like: the set of an earlier search there."""
        reached("searching")
        if like is None:
            found = self._anew(self._from(Fit(now, *searched(now), self.known)))
        else:
            begun = replace(like, linear=now, chosen=now.labelled(like.labels), known=self.known, held=None)
            found = self._from(self._searched(begun))
        reached("bounds")
        best = max((found, *self._partnered(found)), key=lambda f: f.worth)
        return self._within(found if best is found else self._settled(best, best.labels, 3 * _ROUNDS, False))

    def _from(self, made: Fit) -> Fit:
        """The best set, from a fit on: made linear around it and searched again until it settles."""
        self._say(made)
        if made.exact:
            return self._climbed(made)
        for k in range(_ROUNDS):
            reached("searching", k, _ROUNDS)
            now, before = self._stepped(made), made.labels
            made = self._searched(replace(made, linear=now, chosen=now.labelled(before)))
            self._say(made)
            if set(before) == set(made.labels) and made.gain_left < _SETTLED:
                break
        return made

    def _climbed(self, made: Fit) -> Fit:
        """The best set, from a fit on, where only what the model itself makes of the flights counts.

        Under the same weights every step must be worth more than the last, so that it ends.
        """
        made = self._settled(made, made.labels, _ROUNDS, True)
        for k in range(_ROUNDS):
            reached("searching anew", 2 + k, 2 + _ROUNDS)
            other = self._searched(made)
            other = self._settled(other, other.labels, _ROUNDS, True)
            self._say(other)
            if other.worth < made.worth + _SETTLED:
                break
            made = other
        return made

    def _anew(self, made: Fit) -> Fit:
        """The best set around the file, or the healthy model, as it is found to be, every number of it.

        The first columns are made beside the numbers as they are given: where they have moved, an effect that acts on
        what they change would not be told from them as it is.
        """
        now, inside = made.linear, {m.candidate.label for m in made.members}
        point = now.members(made.chosen, made.solution.theta, shift=LOOSE, straight=True)
        if all(m.candidate.label in inside for m in point):
            return made
        reached("searching anew", 0, 2 + _ROUNDS)
        point = now.members(made.chosen, made.solution.theta, shift=0.0, straight=True)
        fresh = linearised(self.observation, point, self.known, like=now, anew=True)
        reached("searching anew", 1, 2 + _ROUNDS)
        kept = replace(self._at(made, made.labels, fresh), exact=True)
        # What the linear model promises of another set is not yet what the model makes of it.
        other = self._searched(kept)
        same = set(other.chosen) == set(kept.chosen) and other.scales == kept.scales
        tried = [self._settled(f, f.labels, _ROUNDS, True) for f in ((kept,) if same else (kept, other))]
        return self._from(max(tried, key=lambda f: f.worth))

    def _within(self, made: Fit) -> Fit:
        """The best set of which no number ends at a physical bound: what needs that stands for something else.

        Of several at a bound the one goes that is worth least; what it stood for is searched anew.
        """
        while True:
            if made.may_fall(_FAR):
                made = self._settled(made, made.labels, 3 * _ROUNDS, False)
            inside = {m.candidate.label for m in made.members if not m.held}
            ended = {k: v for k, v in beyond_bounds(made.members, self.observation.vehicle).items() if k in inside}
            if not ended:
                return made
            sets = {x: tuple(i for i in made.chosen if made.linear.choices[i].label != x) for x in ended}
            least = list(ended)[int(np.argmax(made.scorer.scores(list(sets.values()))))]
            self.barred[least] = ended[least]
            made = self._from(self._searched(replace(made, chosen=sets[least])))

    def hold_parts(self, members: Sequence[Member], ended: Mapping[str, str]) -> bool:
        """Has numbers of a vector that end at a bound stay absent from here on, where others of it do not; whether any.

        A wind from below of more than any wind says that something else is wrong along z, and nothing of the wind from
        the side. ended: labels of effects at a bound.
        """
        vehicle = self.observation.vehicle
        still = {(m.candidate.label, k) for m in members for k in parts_beyond(m, vehicle)}
        still = {(x, k) for x, k in still if x in ended} - self.observation.still
        if not still or self.observation.healthy is not None:
            return False
        self.observation = replace(self.observation, still=self.observation.still | still)
        return True

    def without_parts(self, made: Fit) -> Fit:
        """The same set without the numbers that stay absent."""
        now = replace(made.linear, observation=self.observation)
        return self.fitted(made.labels, replace(made, linear=now), go_on=True)

    def _partnered(self, found: Fit) -> Iterator[Fit]:
        """The same with what an effect acts beside exchanged, under the same weights: its columns are made anew.

        An exchange that is worth less than the set without that effect is left.
        """
        names = {m.candidate.name for m in found.members}
        tried: set[frozenset[str]] = set()
        for m in found.members:
            partners = [x for x in found.members if x.candidate.name in m.candidate.cls.beside and not x.held]
            others = [
                c for c in self.known if c.name in set(m.candidate.cls.beside) - names and c.label not in self.barred
            ]
            rest = tuple(i for i in found.chosen if found.linear.choices[i].label != m.candidate.label)
            for partner, other in product(partners, others) if not m.held else ():
                labels = [other.label if x == partner.candidate.label else x for x in found.labels]
                if frozenset(labels) in tried:
                    continue
                tried.add(frozenset(labels))
                made = self.fitted(labels, found)
                if made.worth < float(found.scorer.scores([rest])[0]):
                    continue
                again = self._searched(made)
                self._say(again)
                yield self._settled(again, again.labels, 1, True)

    def named(self, now: Linear, labels: Sequence[str]) -> Fit:
        """The effects that are asked for, whether these flights need them or not, fitted beside the file's numbers.

        now: where it begins.
        """
        every = [[i for i, c in enumerate(now.choices) if c.label == label] for label in labels]
        # Every start of an effect that has several; the one that explains most is refined.
        sets = [tuple(s) for s in product(*every)]
        tried = [(float(now.scorer(s).scores([x])[0]), k, x) for k, s in enumerate(now.scales) for x in sets]
        _, common, chosen = max(tried)
        scales = scaled(now, chosen, now.scales[common].common)
        return self._settled(Fit(now, chosen, scales, now.scorer(scales).solution(chosen)), labels, 3 * _ROUNDS, False)

    def fitted(
        self, labels: Sequence[str], like: Fit, scales: Scales | None = None, rounds: int = 2, go_on: bool = False
    ) -> Fit:
        """A given set of effects, fitted from the linearisation of another set.

        scales: how far the file is off, the effects of the model staying as they are; where it is not given, as far as
        beside the other set, and they are fitted along. go_on: more is asked from there, so that its columns are made
        anew where numbers have moved.
        """
        now = self._parted(like, labels)
        chosen = now.labelled(labels)
        held = None if scales is None else self.held
        scales = scales or like.scales
        solution = now.scorer(scales, held).solution(chosen)
        begun = Fit(now, chosen, scales, solution, like.known, held, like.exact)
        return self._settled(begun, labels, rounds, True, go_on)

    def _parted(self, like: Fit, labels: Sequence[str]) -> Linear:
        """The model of a fit, made linear anew where an effect has gone that acts on one which stays.

        Their product is not linear: beside the place of a force that has gone, the force would still turn the vehicle.
        """
        now, stay = like.linear, {x.split()[0] for x in labels} | {m.candidate.name for m in like.members if m.held}
        gone = {m.candidate.label for m in like.members if not m.held and m.candidate.label not in labels}
        point = [m for m in now.point if m.candidate.label not in gone or not stay & {*m.candidate.cls.beside}]
        if len(point) == len(now.point) or self.observation.healthy is not None:
            return now
        return linearised(self.observation, point, self.known, like=now, frozen=True)

    def afresh(self, made: Fit) -> Fit:
        """A fit that is gone on from: with columns made anew around its numbers."""
        now = made.linear
        fresh = linearised(self.observation, now.point, self.known, like=now, frozen=True)
        return self._settled(self._at(made, made.labels, fresh), made.labels, 1, True)

    def _settled(self, made: Fit, labels: Sequence[str], rounds: int, frozen: bool, go_on: bool = True) -> Fit:
        """A fit made linear around its own numbers until they settle. frozen: under the weights that it has; go_on:
        more is asked from there, so that no column may be of another place."""
        if made.scales.common == 0.0 and self.observation.healthy is None:
            now = self._without_others(made, frozen)
            columns = sorted({*now.kept, *(c for i in now.labelled(labels) for c in now.choices[i].columns)})
            made = self._at(made, labels, now.weighed_beside(columns))
        for k in range(rounds):
            reached("fitting", k, rounds)
            made, settled = self._nearer(made, labels, rounds, fresh=go_on)
            if settled:
                break
            after = self._at(made, labels, self._stepped(made, frozen))
            # The first step may leave another set behind.
            if made.exact and k and after.worth < made.worth:
                break
            made = after
            if abs(made.gain_left) < _SETTLED:
                break
        return made

    def _nearer(self, made: Fit, labels: Sequence[str], rounds: int, fresh: bool) -> tuple[Fit, bool]:
        """The fit after steps with the columns that it has, while each does what it promised; whether it settled.

        fresh: only where the columns are as good as new ones: of the same set, and each step did nearly all that it
        promised.
        """
        beside_file = made.scales.common == 0.0 and self.observation.healthy is None
        if (not made.exact and not beside_file) or any(made.linear.variants[i] is not None for i in made.chosen):
            return made, False
        inside, as_new = {m.candidate.label for m in made.linear.point}, True
        for k in range(_CHEAP * rounds):
            now, promised = made.linear, made.gain_left
            point = now.members(made.chosen, made.solution.theta, shift=0.0, straight=True)
            as_new = as_new and {m.candidate.label for m in point} == inside
            if abs(promised) < _SETTLED and as_new and fresh:
                return made, True
            moved = now.moved(point)
            if moved is None:
                break
            after = self._at(made, labels, moved)
            left = abs(after.gain_left)
            if k == 0:
                here, there, came = (
                    now.sums.whole_error(np.zeros(now.sums.width)),
                    now.absent.whole_error(made.solution.theta),
                    moved.sums.whole_error(np.zeros(moved.sums.width)),
                )
                if came > max(here, _EXPECTED * there):
                    break
            elif left > max(_CONTRACTS * abs(promised), _SETTLED):
                break
            as_new = as_new and left < max(_ALIKE * abs(promised), _SETTLED)
            made = after
            if left < _SETTLED:
                return made, as_new or not fresh
        return made, False

    def _at(self, made: Fit, labels: Sequence[str], now: Linear) -> Fit:
        """A set fitted in another linearisation."""
        chosen = now.labelled(labels)
        return replace(made, linear=now, chosen=chosen, solution=now.scorer(made.scales, made.held).solution(chosen))

    def _without_others(self, made: Fit, frozen: bool) -> Linear:
        """The model around the numbers that a set's effects have already, and of new ones as found, and no others.

        How far a step from what the file and other effects are off by may go says nothing of a set that leaves them.
        """
        now, inside = made.linear, {m.candidate.label for m in made.linear.point}
        numbers = [
            x if c.candidate.label in inside else y
            for c, x, y in zip(now.columns, now.now, made.solution.theta, strict=True)
        ]
        file = np.array([is_file_number(c.candidate) for c in now.columns], dtype=bool)
        taken = np.isin(np.arange(len(file)), [c for i in made.chosen for c in now.choices[i].columns])
        point = now.members(made.chosen, np.where(file & ~taken, 0.0, numbers), shift=np.inf)
        return linearised(self.observation, point, self.known, like=now, frozen=frozen or made.exact)

    def _stepped(self, made: Fit, frozen: bool = False) -> Linear:
        """The model around the numbers of a solution; where the error does not fall, the best part of the way."""
        now, chosen, theta = made.linear, made.chosen, made.solution.theta
        here = now.sums.whole_error(np.zeros(now.sums.width))
        there = now.absent.whole_error(theta)
        # A file that is taken as it is may leave more than before: as much as the linear model says is expected.
        allowed = max(here, there + _SETTLED if made.exact else _EXPECTED * there)
        left: list[tuple[float, tuple[Member, ...]]] = []
        for k in range(_HALVES):
            numbers = now.now + 0.5**k * (theta - now.now)
            # Beside all that the file is off by, as the linear model has it.
            tried = now.members(chosen, numbers, shift=0.0, straight=True)
            left.append((0.0 if np.array_equal(theta, now.now) else self._error(now, tried), made.next_point(numbers)))
            if left[-1][0] <= allowed or (len(left) > 1 and left[-1][0] > left[-2][0]):
                break
        point = min(left, key=lambda x: x[0])[1]
        return linearised(self.observation, point, self.known, like=now, frozen=frozen or made.exact)

    def _error(self, like: Linear, point: Sequence[Member]) -> float:
        """Weighted squared error of the model at a point, under the weights of a linearisation."""
        o = self.observation
        raw = o.raw(o.model(point))
        if raw is None:
            return float("inf")
        found = spectra(o.samples, o.transforms, binned(o.transforms, raw))
        return float(sum(np.sum(s.weighted(like.weights.of(k, s)) ** 2) for k, s in enumerate(found)))

    def _searched(self, made: Fit) -> Fit:
        """The best set in the linearisation of a fit, from its set on."""
        chosen, scales, solution = searched(made.linear, made.chosen, made.scales, self.barred.keys())
        return replace(made, chosen=chosen, scales=scales, solution=solution)

    def _say(self, made: Fit) -> None:
        labels, scales = " + ".join(made.labels) or "nothing", made.scales
        pieces("weighing", len(made.chosen))
        pieces("naming", len(made.chosen))
        kinds = "".join(f", {k} {v:g}" for k, v in scales.kinds.items())
        self.trail.append(f"{labels}: {made.solution.score:.1f} nats, file off by {scales.common:g} times 1 %{kinds}")
