"""How exactly numbers are told where the file alone anchors them.

Mass, thrusts and moments of inertia that are all larger by one factor move a vehicle alike, and so do arms and moments
of inertia: no flight tells that factor, and every number that goes with it is as exact as the file is. How exact that
is says not how well its rotors agree with one another, for one may write the same number for all of them, and draw all
arms by one wrong length; it is what kinds of numbers differ by from what flights say (evidence; MacKay 1992). One kind
may be off by what is missing. A second one is off because the file is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import SCALES, SLAB, Scales
from infotraj.effects.along import of_arm
from infotraj.effects.rotor_torque import RotorTorque
from infotraj.effects.thrust import RotorEffectiveness, ThrustScale
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_ANCHORS = ("mass", "rotors", "inertia", "moment")  # kinds of which each is measured by itself
_ORDINARY = 1.0  # times 1 %: better than that no file of a real vehicle is
_OPEN = 3.0  # times 1 %: the file beside which it is asked what kinds differ by
_ALL = 0.01  # of all thrusts, or all arms, by one factor, in a file that is right to 1 %
_TOLD = 0.15  # of a number: what flights tell less of says nothing of its kind


def told_errors(made: Fit, told: Fit | None = None) -> Array:
    """Standard errors (p,) of all numbers of a fit, usual sizes, of which a factor in common may be the file's.

    told: a fit beside a file that is free to be wrong, which says how far it is off, where `made` does not.
    """
    wider, covariance = overdispersion(made)
    errors = np.sqrt(np.diag(covariance))
    if made.linear.observation.healthy is not None:
        return errors
    of_file = np.sqrt(np.diag(_covariance(made, off_by(told or made), wider)))
    return np.where(errors > 0.0, np.maximum(errors, of_file), 0.0)


def off_by(made: Fit) -> float:
    """How far this file is off as an anchor, times 1 %: what its second kind of number differs by."""
    return float(np.clip(kinds_off(made)[1], _ORDINARY, max(SCALES)))


def kinds_off(made: Fit) -> list[float]:
    """By how much each kind of number differs from what the file says, times 1 %, the furthest first."""
    columns, ordinary = made.linear.columns, made.linear.spike(Scales(1.0))
    kinds = [c.candidate.cls.declared.kind if c.candidate.cls.declared else "" for c in columns]
    # All thrusts by one factor is the rotors' error, too, by whichever name it is in the set.
    for i in (i for k in made.chosen for i in made.linear.choices[k].columns):
        if columns[i].candidate.cls is ThrustScale:
            kinds[i], ordinary[i] = "rotors", _ALL / columns[i].scale
    prior = _prior(made, _OPEN)
    told = 1.0 - np.diag(_covariance(made, _OPEN, force=False)) / np.where(np.diag(prior) > 0.0, np.diag(prior), 1.0)
    found = []
    for kind in _ANCHORS:
        own = [i for i, x in enumerate(kinds) if x == kind and ordinary[i] > 0.0]
        known = float(np.maximum(told[own], 0.0).sum()) if own else 0.0
        square = float(np.sum((made.solution.theta[own] / ordinary[own]) ** 2))
        found.append(float(np.sqrt(square / known)) if known > _TOLD else 0.0)
    return sorted(found, reverse=True)


def errors_beside(made: Fit, scale: float) -> Array:
    """Standard errors (p,), usual sizes, beside a file that is off so far, thrusts and arms by a factor each, too."""
    return np.sqrt(np.diag(_covariance(made, scale, overdispersion(made)[0])))


def anchored(made: Fit, scale: float) -> Fit:
    """The same set, its numbers beside a file that is off so far at least."""
    scales = _scales(made, scale)
    return replace(made, scales=scales, solution=made.linear.scorer(scales, made.held).solution(made.chosen))


def _scales(made: Fit, scale: float) -> Scales:
    kinds = {k: max(scale, x) for k, x in made.scales.kinds.items()}
    return replace(made.scales, common=max(scale, made.scales.common), kinds=kinds)


def _prior(made: Fit, scale: float) -> Array:
    """Covariance (p, p) of all numbers beside a file that is off so far, its thrusts and its arms by a factor, too.

    Of a vehicle without rotors that factor is of the force that is commanded, whether it is asked for or not.
    """
    linear = made.linear
    file = linear.spike(_scales(made, scale))
    prior = np.diag(file**2)
    vehicle = linear.observation.vehicle
    thrust, arm = np.zeros(len(file)), np.zeros(len(file))
    for i in _force(made):
        thrust[i] = scale * _ALL / linear.columns[i].scale
    for i, c in enumerate(linear.columns):
        if file[i] <= 0.0:
            continue
        if c.candidate.cls is RotorEffectiveness:
            thrust[i] = scale * _ALL / c.scale
        elif c.candidate.cls is RotorTorque:
            arm[i] = scale * _ALL * float(_arm(vehicle, dict(c.candidate.fixed)["rotor"])[c.place]) / c.scale
    slab = np.zeros(len(file))
    for label, columns in ((linear.choices[i].label, linear.choices[i].columns) for i in made.chosen):
        for i in columns:
            slab[i] = 0.0 if label in made.scales.corrects and file[i] > 0.0 else made.scorer.slab[i]
    slab[made.scorer.kept] = SLAB
    return prior + np.diag(slab**2) + np.outer(thrust, thrust) + np.outer(arm, arm)


def _force(made: Fit) -> list[int]:
    """The column of all of the force that is commanded, where no rotor has one of its own."""
    columns, rotors = made.linear.columns, made.linear.observation.vehicle.rotors
    return [] if rotors else [i for i, c in enumerate(columns) if c.candidate.cls is ThrustScale][:1]


def _arm(vehicle: Vehicle, rotor: int) -> Array:
    """Torque (3,) m about the centre of mass of a unit of thrust of the rotors that share an arm with this one."""
    rotors = [vehicle.rotors[i] for i in of_arm(vehicle, rotor)]
    return np.mean([np.cross(np.subtract(r.position, vehicle.center_of_mass), r.axis) for r in rotors], axis=0)


def _covariance(made: Fit, scale: float, wider: float = 1.0, force: bool = True) -> Array:
    """Covariance (p, p) of all numbers beside such a file, 0 for those that are held. wider: of the data's variance;
    force: whether a force that is commanded, and not asked for, is unsure, too."""
    scorer, prior = made.linear.scorer(_scales(made, scale), made.held), _prior(made, scale)
    free = scorer.covariance(made.chosen)[0]
    chosen = {i for k in made.chosen for i in made.linear.choices[k].columns}
    free = np.array([*free, *(i for i in _force(made) if force and i not in {*chosen, *free})], dtype=int)
    size = np.sqrt(np.diag(prior)[free])
    known = np.linalg.inv(prior[np.ix_(free, free)] / np.outer(size, size))
    gram = scorer.parts[0][1:, 1:][np.ix_(free, free)] * np.outer(size, size) / wider
    out = np.zeros_like(prior)
    out[np.ix_(free, free)] = np.linalg.inv(gram + known) * np.outer(size, size)
    return out
