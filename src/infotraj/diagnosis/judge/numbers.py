"""The numbers of fitted effects and of the vehicle file, with their standard errors."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.judge.anchor import told_errors
from infotraj.diagnosis.judge.evidence import moving, of_number, overdispersion, variance_along
from infotraj.diagnosis.judge.unexplained import NOTHING_LEFT, Unexplained, more_stays
from infotraj.diagnosis.linear.candidates import Candidate, places, slopes
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.around import Column
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import PULL, SCALES, TIMES, Scales, stamped
from infotraj.diagnosis.select.reading import unread
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

ORDINARY = 3.0  # standard deviations of this file's own errors: further off, a number is a finding
OF_THRUST_OVER_MASS = frozenset({"mass_offset", "thrust_scale", "coaxial_loss"})  # names that say it
OVER_MASS = "over mass, factor"  # how names end that tell it
_OF_THRUST = ("inertia", "axes")  # kinds that are told beside a thrust, and in proportion to it
_HALF = 0.5  # of the root mean square error; of what two numbers that are as likely differ by, from their mean
_OF_PREDICTION = ("inertia", "axes", "rotors", "moment", "arms", "time", "clock")  # kinds that make it larger, or later
_SEEN = 3.0  # standard errors by which a file number must be off to be told


@dataclass(frozen=True)
class FileNumber:
    """What one number of the vehicle file should say. ordinary: within what this file's numbers are off by; unit: of
    value, declared and error, empty where they have none; takes: share of an axis' error of flights that were not
    fitted that goes with it, where that is most, and 0 where other numbers may stand for it; doubt: why it may be
    wrong, though flights tell it with that error; label: of the effect that says it, empty of a ratio; on: axes fx to
    tz of whose error half and more goes with it."""

    name: str
    declared: float
    value: float
    standard_error: float
    ordinary: bool
    unit: str = ""
    takes: float = 0.0
    doubt: str = ""
    label: str = ""
    on: tuple[str, ...] = ()

    @property
    def ratio(self) -> bool:
        """Whether it is what pushes over the mass, and not the one or the other."""
        return self.name.endswith(OVER_MASS)

    @property
    def large(self) -> bool:
        """Whether half of an axis' error goes with it, for sure."""
        return self.takes > _HALF and not self.doubt


def values_of(m: Member) -> dict[str, Any]:
    """What is fixed and what is fitted of a member, other forms of the effect left out."""
    wanted = {*dict(m.candidate.fixed), *(p.name for p in m.candidate.form)}
    return {k: v for k, v in m.effect.values.items() if k in wanted}


def fitted_numbers(made: Fit, told: Fit | None = None) -> list[dict[str, Any]]:
    """Standard errors of every member of a fit by parameter. told: see `anchor.told_errors`."""
    vehicle = made.linear.observation.vehicle
    deviation = told_errors(made, told)
    if made.linear.observation.healthy is not None:
        deviation = np.sqrt(overdispersion(made)[0]) * made.changes[2]
    # Beside healthy flights a change is told: stamps are off alike.
    out, step = [], 0.0 if made.linear.observation.healthy is not None else made.linear.observation.command_step
    for m in made.members:
        at = m.places(vehicle)
        values, slope = np.zeros(len(at)), slopes(m.effect, at)
        for i, c in enumerate(made.linear.columns):
            if c.candidate.label == m.candidate.label and deviation[i] > 0:
                told_to = deviation[i] * abs(c.scale) * slope[c.place]
                late = unread(c.candidate, made.linear.observation) if step else 0.0
                values[c.place] = np.linalg.norm([told_to, stamped(c.candidate, step) + _pulled(m, made), late])
        out.append(by_parameter(m, values))
    return out


def _pulled(m: Member, made: Fit) -> float:
    """How exactly gravity tells a mass (kg) or the thrust of all rotors (factor); 0 for any other, or for a change."""
    vehicle = made.linear.observation.vehicle
    if made.linear.observation.healthy is not None:
        return 0.0
    return PULL * {"mass_offset": vehicle.mass or 0.0, "thrust_scale": 1.0}.get(m.candidate.name, 0.0)


def in_fit(made: Fit, label: str, told: Fit) -> tuple[Member, dict[str, Any]]:
    """One member of a fit, and its standard errors (see `fitted_numbers`)."""
    k = [m.candidate.label for m in made.members].index(label)
    return made.members[k], fitted_numbers(made, told)[k]


def by_parameter(m: Member, values: Array) -> dict[str, Any]:
    """Numbers of a member by parameter, a list where the parameter is one."""
    out, place = {}, 0
    for p in m.candidate.form:
        size = np.size(getattr(m.effect, p.name))
        part = [float(v) for v in values[place : place + size]]
        out[p.name] = part[0] if p.size == 1 else part
        place += size
    return out


def file_numbers(
    made: Fit,
    named: Container[str],
    unsure: Mapping[str, str] | None = None,
    faint: Mapping[str, float] | None = None,
    own_error: AbstractSet[str] = frozenset(),
    others: Sequence[Fit] = (),
    left: Unexplained = NOTHING_LEFT,
) -> tuple[FileNumber, ...]:
    """The numbers of the vehicle file, its clocks and frames, that these flights show to be off.

    named: effects that are named. What is found and not named may be the file's as well: it is told here. unsure: why
    numbers of effects may be wrong; faint: axes of torque that the set hardly predicts, and the share that it does;
    own_error: effects in the set that are what the file is off by; others: fits with what stands in the place of names:
    which of them holds is not known, and numbers are no surer than half of what they differ by (Draper 1995). left:
    structure that the set leaves.
    """
    vehicle = made.linear.observation.vehicle
    if made.linear.observation.healthy is not None:
        return ()
    bound, made = made.labels, out_of_line_freed(made, named)
    others = [_freed(x, [label for label in made.labels if label not in bound]) for x in others]
    reasons, faint = unsure or {}, faint or {}
    inside = {x: reasons.get(x.split()[0], "") for x in made.labels}
    of_ratio = next((r for x, r in inside.items() if r and x in OF_THRUST_OVER_MASS), "")
    in_line = bool(OF_THRUST_OVER_MASS & own_error)
    ratio = thrust_over_mass(made, named, faint=faint, others=others)
    out = [replace(n, doubt=of_ratio, ordinary=n.ordinary or in_line) for n in ratio]
    of_mass = _half_of_mass(made)
    elsewhere = [_as_in(x, made.linear.columns) for x in others]
    for i, c, theta, deviation, spike in off(made, named):
        kind = c.candidate.cls.declared
        assert kind is not None  # a number of the file is declared
        name, declared, per = c.candidate.cls.in_the_file(vehicle, c.place, dict(c.candidate.fixed).get("rotor", 0))
        at = places(c.candidate, vehicle)[c.place]
        moved = at.value(at.absent + theta * c.scale)
        apart = _HALF * max((abs(theta - x[i]) for x in elsewhere if x[i] != 0.0), default=0.0)
        error = abs(np.hypot(deviation, apart) * per * c.scale) * at.slope(moved)
        value, unit = declared + per * (moved - at.absent), _unit(c.candidate, at.parameter, name)
        if kind.kind == "mass":
            error = np.hypot(error, PULL * declared)
        if kind.kind in _OF_THRUST:
            error = np.hypot(error, of_mass * abs(value))
        if abs(theta) < _SEEN * np.hypot(deviation, apart) or abs(value - declared) < _SEEN * error:
            continue
        ordinary = bool(abs(theta) < ORDINARY * spike) or c.candidate.name in own_error
        own = np.eye(len(made.linear.columns))[i]
        takes, on = _most(_takes(made, own, faint)) if kind.alone or not ordinary else (0.0, ())
        doubt = inside.get(c.candidate.label, "") or _told_by(made, c, own, faint)
        doubt = doubt or _beside_more(made, i, left)
        label = c.candidate.label
        out.append(FileNumber(name, declared, value, float(error), ordinary, unit, takes, doubt, label, on))
    return tuple(out)


def out_of_line_freed(made: Fit, named: Container[str]) -> Fit:
    """The fit with what is out of line with the file told as an effect is: no file's error holds it back, or is told in
    its place. Thrust over mass, which is of several numbers, stays as it is, and so do times: where they would be then
    the model is not linear in them."""
    choices, linear = made.linear.choices, made.linear
    far = [c.candidate for _, c, theta, _, spike in off(made, named) if abs(theta) >= ORDINARY * spike]
    out = {c.label for c in far if c.cls.declared is not None and c.cls.declared.kind not in TIMES}
    out -= {*made.labels, *OF_THRUST_OVER_MASS}
    more = linear.labelled([x for x in dict.fromkeys(c.label for c in choices if np.isfinite(c.price)) if x in out])
    return _freed(made, [choices[i].label for i in more])


def _freed(made: Fit, labels: Sequence[str]) -> Fit:
    """The fit with these effects in its set as well."""
    has = {c.label for c in made.linear.choices} - {*made.labels}
    more = made.linear.labelled([x for x in labels if x in has]) if labels else ()
    if not more:
        return made
    chosen = (*made.chosen, *more)
    return replace(made, chosen=chosen, solution=made.scorer.solution(chosen))


def _as_in(other: Fit, columns: Sequence[Column]) -> Array:
    """The numbers (p,) of these columns in another fit, usual sizes; 0 for what it has not."""
    own = zip(other.linear.columns, other.solution.theta, strict=True)
    has = {(c.candidate.label, c.place): float(x) for c, x in own}
    return np.array([has.get((c.candidate.label, c.place), 0.0) for c in columns])


def _half_of_mass(made: Fit) -> float:
    """Share of moments of inertia that is unsure: half of what thrust over mass is off by. They are told beside a
    thrust; if it is the mass they are as much larger (two models that are as likely; Draper 1995)."""
    return max((_HALF * abs(float(np.log(n.value))) for n in thrust_over_mass(made, ())), default=0.0)


def beside_what_stays(numbers: Sequence[FileNumber], stays: float, vehicle: Vehicle) -> tuple[FileNumber, ...]:
    """The numbers, thrust over mass no surer than a force along z (N) that stays and may be as large in the mean; not
    told where it is then no longer off."""
    share = stays / (vehicle.mass * vehicle.gravity) if vehicle.mass else 0.0
    out = [
        replace(n, standard_error=float(np.hypot(n.standard_error, n.value * share))) if n.ratio else n for n in numbers
    ]
    return tuple(n for n in out if not n.ratio or abs(n.value - n.declared) >= _SEEN * n.standard_error)


def _told_by(made: Fit, c: Column, own: Array, faint: Mapping[str, float]) -> str:
    """That a torque tells a number, own (p,), of which less than half goes with the prediction; empty if not.

    What cannot be predicted makes the factors of a prediction smaller, and moments of inertia larger (Fuller 1987). One
    rotor's thrust is told from the others' by torques, however short its arm has become.
    """
    kind = c.candidate.cls.declared
    if not faint or kind is None or kind.kind not in _OF_PREDICTION:
        return ""
    k = 1 + int(np.argmax(own))
    axis = made.linear.sums.axes[int(np.argmax(made.linear.sums.gram[:, :, k, k].sum(axis=1)))]
    if kind.kind == "rotors" and faint.keys() >= {"tx", "ty"}:
        axis = max("tx", "ty", key=faint.__getitem__)
    share = faint.get(axis)
    return "" if share is None else f"only {100 * share:.0f} % of the torque about {axis[1]} goes with the prediction"


def _beside_more(made: Fit, i: int, left: Unexplained) -> str:
    """That a number may be part of what is left, of which there is more than it takes off; empty if not, and where it
    takes half of an error off."""
    if not left.found:
        return ""
    falls, rises = of_number(made, i)
    return more_stays(left, falls, rises) if sum(falls.values()) < -math.log(_HALF) else ""


def labels_of_file(made: Fit) -> list[str]:
    """Labels of what says what the file is off by and acts on these flights; clocks and mounts of sensors do not.

    Commands that act later do so in every log of the vehicle.
    """
    acts = np.diag(made.linear.sums.total)[1:] > 0.0
    named = dict.fromkeys(c.label for c in made.linear.choices if acts[list(c.columns)].any())
    of = {c.candidate.label: c.candidate.cls for c in made.linear.columns}
    kinds = {x: of[x].declared for x in named if of[x].place != "measurement"}
    return [x for x, declared in kinds.items() if declared is not None]


def off(made: Fit, named: Container[str]) -> Iterator[tuple[int, Column, float, float, float]]:
    """File numbers that are sure not to be what the file says: place, column, number, its standard error and what this
    file is off by, usual sizes."""
    spike = made.linear.spike(made.scales)
    deviation, step = told_errors(made), made.linear.observation.command_step
    for i, c in enumerate(made.linear.columns):
        theta = made.solution.theta[i]
        if deviation[i] > 0.0:
            late = unread(c.candidate, made.linear.observation) if step else 0.0
            deviation[i] = np.linalg.norm(
                [deviation[i], stamped(c.candidate, step) / abs(c.scale), late / abs(c.scale)]
            )
        inside = spike[i] <= 0 or c.candidate.name in named or deviation[i] <= 0
        if not inside and abs(theta) >= _SEEN * deviation[i]:
            yield i, c, float(theta), float(deviation[i]), float(spike[i])


def _most(takes: Mapping[str, float]) -> tuple[float, tuple[str, ...]]:
    """Of shares by axis of the residual the largest, and the axes fx .. tz of which it is most."""
    on = dict.fromkeys(refusal.axis_group(a) for a, share in takes.items() if share > _HALF)
    return max(takes.values(), default=0.0), tuple(a for a in on if a is not None)


def _takes(made: Fit, along: Array, faint: Container[str] = ()) -> dict[str, float]:
    """Share of the error of each axis, of flights that were not fitted, that numbers along a direction (p,) take.

    faint: axes that the model hardly predicts, of which a smaller prediction takes error as well.
    """
    sums, each = made.linear.absent, made.solution.each
    without = each - np.outer(each @ along, along) / (along @ along)
    sure = moving(made) & np.array([a not in faint for a in sums.axes])
    before, left = (np.maximum(sums.plain_error(x)[sure], 0.0) for x in (without, each))
    of = np.array(sums.axes)[sure][before > 0.0]
    shares = np.maximum(1.0 - np.sqrt(left[before > 0.0] / before[before > 0.0]), 0.0)
    return dict(zip(of.tolist(), shares.tolist(), strict=True))


def _unit(candidate: Candidate, parameter: str, name: str) -> str:
    """The unit of a file number: of the effect's own, but for a factor that changes a coefficient of the file."""
    if name.endswith("thrust_coefficient"):
        return "N s^2/rad^2"
    unit = next(p.unit for p in candidate.form if p.name == parameter)
    return "" if unit == "-" else unit


def thrust_over_mass(
    made: Fit,
    named: Container[str] | None = None,
    scales: Scales | None = None,
    faint: Container[str] = (),
    others: Sequence[Fit] = (),
) -> list[FileNumber]:
    """By which factor what pushes over the mass is off, where flights show it; none where a name says it.

    Accelerations tell the ratio, and hardly ever which of the two is off: each alone may be within its error.
    named: effects that are named, those of the fit where not given: what is in the fit and not named is told here.
    scales: how far the file is off, to judge it by; as it was found to be where not given. faint: axes that the model
    hardly predicts; others: as `file_numbers` takes them.
    """
    linear = made.linear
    vehicle = linear.observation.vehicle
    inside = {x.split()[0] for x in made.labels}
    said = {x for x in inside | OF_THRUST_OVER_MASS if x in (inside if named is None else named)}
    # What pairs of rotors lose is no part of a sum.
    if said & OF_THRUST_OVER_MASS or "coaxial_loss" in inside or not vehicle.mass:
        return []
    spike = linear.spike(scales or made.scales)
    weight = np.zeros(len(linear.columns))
    rotors = [c.candidate.name == "rotor_effectiveness" and spike[i] > 0 for i, c in enumerate(linear.columns)]
    unsaid = [c.candidate.label not in made.labels or c.candidate.name not in said for c in linear.columns]
    # A rotor that is named has its thrust by that name: of the others no less is told.
    factors = {
        i: float(np.exp(made.solution.theta[i] * c.scale))
        for i, c in enumerate(linear.columns)
        if rotors[i] and unsaid[i]
    }
    if any(rotors) and not factors:
        return []
    for i, c in enumerate(linear.columns):
        name = c.candidate.name
        if not unsaid[i]:
            continue
        if name == "thrust_scale" and name in inside:
            weight[i] = c.scale
        elif rotors[i]:
            weight[i] = c.scale / len(factors)
        elif name == "mass_offset" and spike[i] > 0:
            weight[i] = -c.scale / vehicle.mass
    # Coordinates are logarithms: a ratio is a sum.
    total = float(weight @ made.solution.theta)
    error = math.sqrt(variance_along(made, weight))
    apart = _HALF * max((abs(total - float(weight @ _as_in(x, linear.columns))) for x in others), default=0.0)
    error = float(np.linalg.norm([error, PULL, apart])) if error > 0 else 0.0
    if error <= 0 or abs(total) < _SEEN * error:
        return []
    ordinary = abs(total) < ORDINARY * float(np.linalg.norm(weight * spike))
    factor = float(np.exp(total)) * _summed(factors, vehicle, linear.columns)
    takes, on = (0.0, ()) if scales else _most(_takes(made, weight, faint))
    force = vehicle.drive.force if len(factors) == sum(rotors) else vehicle.drive.force.replace("all", "the other")
    return [FileNumber(f"{force} {OVER_MASS}", 1.0, factor, error * factor, ordinary, takes=takes, on=on)]


def _summed(factors: Mapping[int, float], vehicle: Vehicle, columns: Sequence[Column]) -> float:
    """What the sum of the rotors' thrusts is times their factors' geometric mean, by column: thrusts are added, each as
    large as the file has it at the same input."""
    if not factors:
        return 1.0
    rotors = [vehicle.rotors[dict(columns[i].candidate.fixed)["rotor"]] for i in factors]
    coefficients = [r.thrust_coefficient if r.input == "speed" else sum(r.thrust_polynomial or (1.0,)) for r in rotors]
    each = [k or 1.0 for k in coefficients]
    own = np.array(list(factors.values()))
    return float(np.average(own, weights=each) / np.exp(np.mean(np.log(own))))


def out_of_line(made: Fit, named: Container[str]) -> bool:
    """Whether thrust over mass, which no effect of the set in `named` says, is further off than in files that are off
    by ten percent."""
    return any(not n.ordinary for n in thrust_over_mass(made, named, scales=Scales(max(SCALES))))


def number_in_words(name: str, value: Any, error: Any, between: str = " ") -> str:
    """A parameter with its standard error, no more digits than the error leaves: `d [0.0982, 0.1] +- [0.002, 0.01]`."""
    values = value if isinstance(value, list) else [value]
    errors = [None] * len(values) if error is None else error if isinstance(error, list) else [error]
    shown = [_digits(v, s) for v, s in zip(values, errors, strict=True)]
    text = name + between + (f"[{', '.join(shown)}]" if isinstance(value, list) else shown[0])
    if error is None:
        return text
    said = ["?" if s is None else f"{s:.2g}" for s in errors]
    return f"{text} +- [{', '.join(said)}]" if isinstance(value, list) else f"{text} +- {said[0]}"


def _digits(value: float | None, error: float | None) -> str:
    """The value to the second digit of its standard error; to four digits where there is none."""
    if value is None:
        return "?"
    if isinstance(value, int):
        return str(value)
    if not error or not math.isfinite(error) or value == 0.0:
        return f"{value:.4g}"
    digits = 2 + math.floor(math.log10(abs(value))) - math.floor(math.log10(error))
    return f"{value:.{min(max(digits, 1), 6)}g}"
