"""Products of inertia other than the file's: what stands for them is not named, nor told as other numbers.

A load beside the planes of symmetry turns a vehicle about z as it rolls. Without a number of its own that is told as an
IMU that is turned, or as moment constants below zero. Three more numbers in every file's search, nearly zero in most,
made files look more exact than they are; so they are free beside the sets that were found, where flights show them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np

from infotraj.diagnosis.judge.evidence import Evidence, evidence, little, overdispersion, shared
from infotraj.diagnosis.judge.groups import AS_PROBABLE
from infotraj.diagnosis.linear.candidates import Candidate
from infotraj.diagnosis.select.around import linearised
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.predicting import TELLS
from infotraj.diagnosis.select.search import Search
from infotraj.effects.inertia_products import InertiaProducts

_BESIDE = "beside products of inertia other than the file's "


@dataclass(frozen=True)
class Products:
    """Sets beside free products of inertia. search: with their candidate."""

    search: Search
    candidate: Candidate
    _made: dict[int, tuple[Fit, Fit]] = field(default_factory=dict)

    def beside(self, told: Fit) -> Fit:
        """A set, fitted anew beside products that are free."""
        if id(told) not in self._made:
            self._made[id(told)] = told, self.at(told).fitted(told.labels, self._begun(told), go_on=True)
        return self._made[id(told)][1]

    def _begun(self, told: Fit) -> Fit:
        """The same fit, with columns of products beside."""
        linear, known = told.linear, self.search.known
        now = linearised(linear.observation, linear.point, known, like=linear, frozen=True)
        chosen = now.labelled(told.labels)
        solution = now.scorer(told.scales, told.held).solution(chosen)
        return replace(told, linear=now, known=known, chosen=chosen, solution=solution)

    def at(self, told: Fit) -> Search:
        """The search that goes with a set beside them."""
        return replace(self.search, observation=told.linear.observation)

    def explain(self, told: Fit, names: Collection[str], rng: np.random.Generator) -> dict[str, str]:
        """Those of these names of a set that predict too little beside free products, and how little."""
        made, found = self.beside(told), {}
        if not names:
            return {}
        for label in made.labels:
            rest = self.at(told).fitted([x for x in made.labels if x != label], made)
            found[label] = evidence(made, label, rng, rest)
        gain: dict[str, Evidence] = {}
        for label, e in shared(made, found).items():
            name = label.split()[0]
            gain[name] = max(gain.get(name, e), e, key=lambda x: x.gain)
        return {n: f"{_BESIDE}{little(e)}" for n, e in gain.items() if n in names and e.gain < TELLS}


def free_products(search: Search, whole: Fit) -> Products | None:
    """Products of inertia that are free, where the search's set is more probable beside them for sure; else None.

    Beside healthy flights they are free in any case.
    """
    known = (*search.known, *(m.candidate for m in search.held))
    if search.observation.healthy is not None or not search.known or not (candidates := products(known)):
        return None
    (candidate,) = candidates
    found = Products(replace(search, known=(*search.known, candidate)), candidate)
    sure = found.beside(whole).worth - whole.worth > AS_PROBABLE * overdispersion(whole)[0]
    return found if sure else None


def products(known: Collection[Candidate]) -> list[Candidate]:
    """The candidate of the products, where moments can be asked about or are in the model, and it is not in `known`."""
    names = {c.name for c in known}
    asked = "inertia_error" in names and InertiaProducts.name not in names
    return [Candidate(InertiaProducts, InertiaProducts.parameters)] if asked else []
