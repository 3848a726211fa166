"""Findings about units, frames and orders: the declared reading against the best of all readings.

A convention error is reported only where (1) another reading explains the log at least half as well again (product
over axes and identities of the residual variances), (2) a J test with standard errors over 1 s blocks is sure of it,
with Bonferroni's correction for the number of readings, and (3) the other reading explains the log in absolute terms.
Otherwise check abstains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from infotraj.checking.attitude import READINGS
from infotraj.checking.finding import Finding
from infotraj.checking.likelihood import AXES, sure_of_difference
from infotraj.checking.readings import DEGREE, NOISE, PENALTY, Joint, Pose, Table, Vector
from infotraj.rotations import Array

HALF_AS_WELL_AGAIN = float(np.log(1.5))
SURE = 0.99
MOST_UNEXPLAINED = 0.5
# A quarter of g: with a larger rest the accelerometer is not understood by any reading.
MOST_FORCE_REST = 2.5
HARMLESS_FORCE = 0.4  # m/s^2: what a good accelerometer and a differentiated velocity leave together
RIVAL = 1.2 * PENALTY
SPOILS = "every comparison of model and measurement would be wrong"

FACTORS: tuple[str, ...] = (
    *(f"pose.{k}" for k in ("attitude", "axes", "unit", "down")),
    *(f"{c}.{k}" for c in ("rate", "velocity", "force") for k in ("turn", "axes", "unit")),
    "force.removed",
)


@dataclass(frozen=True)
class Verdict:
    """The best joint reading, the one that is kept for further checks, its pose index, and the findings."""

    joint: Joint
    pose: int
    findings: list[Finding]


def convention_findings(table: Table) -> Verdict:
    """Judges the declared reading of a flight against all others."""
    best, best_at, _ = table.best()
    if not _moves(table, best, best_at):
        table = _without_units(table)
        best, best_at, _ = table.best()
    # a position whose acceleration is noise is no error: the declared reading may have it too
    declared = Joint(pose=Pose(unit=NOISE)) if best.pose.unit == NOISE else Joint()
    declared_at = table.poses.index(declared.pose)
    changed = [f for f in FACTORS if _part(best, f) != _part(declared, f)]
    if not changed or not _rejected(table, declared, declared_at, best, best_at, _tried(table)):
        return Verdict(declared, declared_at, [])
    best, best_at = _without_unproven(table, declared, best, best_at, changed)
    changed = [f for f in FACTORS if _part(best, f) != _part(declared, f)]
    if (
        not changed
        or not _understood(table, best, best_at, changed)
        or _harmless(table, declared, declared_at, changed)
    ):
        return Verdict(declared, declared_at, [])
    sure = _sure(table, declared, declared_at, best, best_at, _tried(table))
    findings = [_finding(table, best, best_at, f, sure) for f in changed]
    rivals = _rivals(table, best, best_at)
    if rivals:
        texts = " and ".join
        others = "; or ".join(texts(sorted({_SENTENCES[f](joint)[1] for f in _changes(joint)})) for joint in rivals[:3])
        codes = sorted({_SENTENCES[f](joint)[0] for joint in rivals for f in _changes(joint)})
        first = findings[0]
        findings[0] = replace(
            first,
            what=f"{first.what}; these data fit as well that {others}",
            values={**first.values, "alternatives": codes},
        )
    return Verdict(best, best_at, findings)


def _what(joint: Joint) -> list[tuple[str, object]]:
    return [(factor, _part(joint, factor)) for factor in _changes(joint)]


def _changes(joint: Joint) -> list[str]:
    plain = Joint()
    return [f for f in FACTORS if _part(joint, f) != _part(plain, f) and _part(joint, f) != NOISE]


def _rivals(table: Table, best: Joint, at: int) -> list[Joint]:
    """Other explanations that fit hardly worse and take at most one change more: what this flight cannot tell apart."""
    found = []
    _, _, value = table.best()
    candidates = [table.best_for(k) for k in range(len(table.poses))]
    for name, identity in table.identities.items():
        for k in range(1, len(AXES)):
            other = replace(getattr(best, name), axes=k)
            likelihood = identity.likelihood(at, other) - identity.likelihood(at, getattr(best, name))
            total = value + likelihood - other.penalty + getattr(best, name).penalty
            candidates.append((replace(best, **{name: other}), at, total))
    for joint, k, total in sorted(candidates, key=lambda c: -c[2]):
        # another explanation, not the same one with something on top
        fresh = bool(_changes(joint)) and not any(set(_what(j)) <= set(_what(joint)) for j in (best, *found))
        if fresh and total > value - RIVAL and _margin(table, joint, k, best, at) < HALF_AS_WELL_AGAIN:
            found.append(joint)
    return found


def _without_unproven(table: Table, declared: Joint, best: Joint, at: int, changed: list[str]) -> tuple[Joint, int]:
    # a change that the data do not need (without it, all else as in `best`, the fit is hardly worse) is undone
    for factor in changed:
        simpler = _reset(best, factor, declared)
        if simpler.pose not in table.poses:
            continue
        simpler_at = table.poses.index(simpler.pose)
        if not _rejected(table, simpler, simpler_at, best, at, 1):
            best, at = simpler, simpler_at
    return best, at


def _rejected(table: Table, worse: Joint, worse_at: int, better: Joint, better_at: int, tried: int) -> bool:
    return (
        _margin(table, worse, worse_at, better, better_at) >= HALF_AS_WELL_AGAIN
        and _sure(table, worse, worse_at, better, better_at, tried) >= SURE
    )


def _margin(table: Table, worse: Joint, worse_at: int, better: Joint, better_at: int) -> float:
    total = 0.0
    for name, identity in table.identities.items():
        gain = identity.likelihood(better_at, getattr(better, name)) - identity.likelihood(
            worse_at, getattr(worse, name)
        )
        total += 2 * gain / identity.moments.independent
    return total


def _sure(table: Table, worse: Joint, worse_at: int, better: Joint, better_at: int, tried: int) -> float:
    labels = np.unique(np.concatenate([i.moments.labels for i in table.identities.values()]))
    sums = np.zeros((3, len(labels)))
    for name, identity in table.identities.items():
        m = identity.moments
        channel, other = identity.series(better_at, getattr(better, name))
        _, declared = identity.series(worse_at, getattr(worse, name))
        noise = ((channel - other) ** 2).mean(axis=0) + m.floor
        d = (other - declared) / noise
        where = np.searchsorted(labels, m.labels)[m.block]
        np.add.at(sums[0], where, ((channel - declared) * d).sum(axis=1))
        np.add.at(sums[1], where, ((other - declared) * d).sum(axis=1))
        np.add.at(sums[2], where, ((channel - other) * d).sum(axis=1))
    return sure_of_difference(*sums, tried=tried)


def _tried(table: Table) -> int:
    return len(table.poses) + sum(i.values[0].size for i in table.identities.values())


def _understood(table: Table, best: Joint, at: int, changed: list[str]) -> bool:
    for name, identity in table.identities.items():
        touched = any(f.startswith((name, "pose")) for f in changed)
        if not touched:
            continue
        vector: Vector = getattr(best, name)
        if name == "force":
            unit = vector.unit
            if identity.rms(at, vector) / unit > MOST_FORCE_REST:
                return False
        elif identity.unexplained(at, vector) > MOST_UNEXPLAINED:
            return False
    return True


def _harmless(table: Table, declared: Joint, at: int, changed: list[str]) -> bool:
    """Whether a change of the force's reading alone is not worth a rejection.

    The force of a vehicle that hardly tilts is nearly the same in both frames: small errors of the motion capture can
    then favour the wrong one. Where the position says nothing about acceleration, gravity alone is compared, and the
    thrust of a multirotor with fixed rotors, always along its own z axis, looks like gravity in the world frame.
    """
    if "force" not in table.identities or not all(f.startswith("force") for f in changed):
        return False
    return declared.pose.unit == NOISE or table.identities["force"].rms(at, declared.force) < HARMLESS_FORCE


def _moves(table: Table, best: Joint, at: int) -> bool:
    """False where a unit of the position only shrinks the noise of its acceleration.

    Noise in a prediction favours smaller ones: at noise as large as the motion, a third of it fits better than all of
    it. Such a reading explains at most as much of the motion as it shrinks it, so it must explain more than half.
    """
    if best.pose.unit in (1.0, NOISE) or "velocity" in table.identities or "force" not in table.identities:
        return True
    force = table.identities["force"]
    noise = replace(best.pose, unit=NOISE)
    if noise not in table.poses:
        return True
    still, _ = force.residual(table.poses.index(noise), best.force)
    moving, _ = force.residual(at, best.force)
    return bool(moving.sum() < MOST_UNEXPLAINED * still.sum())


def _without_units(table: Table) -> Table:
    allowed = np.array([p.unit in (1.0, NOISE) for p in table.poses])
    return replace(table, prior=np.where(allowed, table.prior, -np.inf))


def _part(joint: Joint, factor: str) -> object:
    channel, key = factor.split(".")
    return getattr(getattr(joint, channel), key)


def _reset(joint: Joint, factor: str, declared: Joint) -> Joint:
    channel, key = factor.split(".")
    plain = getattr(getattr(declared, channel), key)
    return replace(joint, **{channel: replace(getattr(joint, channel), **{key: plain})})


def _finding(table: Table, best: Joint, at: int, factor: str, sure: float) -> Finding:
    code, what, remedy, channels = _SENTENCES[factor](best)
    names = [n for n in table.identities if factor.startswith(("pose", n))]
    declared_at = table.poses.index(Pose())
    rest = {}
    for name in names:
        identity = table.identities[name]
        rest[name] = {
            "unexplained_as_declared": identity.unexplained(declared_at, Vector()),
            "unexplained_as_found": identity.unexplained(at, getattr(best, name)),
        }
    numbers = "; ".join(
        f"{name}: {_percent(r['unexplained_as_declared'])} unexplained as declared, "
        f"{_percent(r['unexplained_as_found'])} so"
        for name, r in rest.items()
    )
    return Finding(
        code, "reject", f"{what} ({numbers})", SPOILS, remedy, sure=min(sure, 0.9999), channels=channels, values=rest
    )


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share < 100 else f"{share:.3g} times its own size"


_NAMES = {"rate": ("wx", "wy", "wz"), "velocity": ("vx", "vy", "vz"), "force": ("ax", "ay", "az")}
_WORDS = {"rate": "angular velocity", "velocity": "velocity", "force": "specific force"}
_CODES = {"rate": "rate", "velocity": "velocity", "force": "acceleration"}
Sentence = tuple[str, str, str, tuple[str, ...]]


def _attitude(joint: Joint) -> Sentence:
    reading = READINGS[joint.pose.attitude]
    return reading.code, f"the attitude {reading.what}", reading.remedy, ("qw", "qx", "qy", "qz")


def _pose_axes(joint: Joint) -> Sentence:
    return (
        "position_frame",
        f"positions are given in {_world(joint.pose.axes)} axes, not in those of the attitude",
        f"declare the position's frame as {joint.pose.axes}",
        ("px", "py", "pz"),
    )


def _pose_unit(joint: Joint) -> Sentence:
    return (
        "position_unit",
        f"positions are {joint.pose.unit:g} times too large for metres",
        f"scale the position by {1 / joint.pose.unit:g}",
        ("px", "py", "pz"),
    )


def _pose_down(joint: Joint) -> Sentence:
    return (
        "world_z_down",
        "the world's z axis points down (gravity acts along +z)",
        "declare world frame NED (z down) and body frame FRD",
        ("pz", "vz", "qw", "qx", "qy", "qz"),
    )


def _turn(channel: str) -> Callable[[Joint], Sentence]:
    word, code, names = _WORDS[channel], _CODES[channel], _NAMES[channel]

    def sentence(joint: Joint) -> Sentence:
        turn = getattr(joint, channel).turn
        world = channel == "velocity"
        if world:
            what = (
                f"{word} is in the body frame, not the world's"
                if turn < 0
                else f"{word} was in the world frame already and was turned from body to world once too often"
            )
            remedy = "declare the velocity's frame as " + ("body" if turn < 0 else "world")
        else:
            what = (
                f"{word} is in the world frame, not the body's"
                if turn > 0
                else f"{word} was in the body frame already and was turned from world to body once too often"
            )
            remedy = f"declare the frame of {names[0]}..{names[2]} as " + ("world" if turn > 0 else "body")
        return f"{code}_frame", what, remedy, names

    return sentence


def _unit(channel: str) -> Callable[[Joint], Sentence]:
    word, code, names = _WORDS[channel], _CODES[channel], _NAMES[channel]

    def sentence(joint: Joint) -> Sentence:
        unit = getattr(joint, channel).unit
        special = {
            ("rate", True): "is in deg/s, not rad/s",
            ("rate", False): "was in rad/s and was converted from deg/s",
            ("force", False): "is in g, not m/s^2",
            ("force", True): "was in m/s^2 and was multiplied by g",
        }.get((channel, unit > 1), f"is {unit:.4g} times that of m/s")
        known = channel == "rate" and not np.isclose(unit, DEGREE, rtol=0.1) and not np.isclose(unit * DEGREE, 1, 0.1)
        text = f"is {unit:.4g} times that of rad/s" if known else special
        return f"{code}_unit", f"{word} {text}", f"scale {names[0]}..{names[2]} by {1 / unit:.6g}", names

    return sentence


def _axes(channel: str) -> Callable[[Joint], Sentence]:
    word, code, names = _WORDS[channel], _CODES[channel], _NAMES[channel]

    def sentence(joint: Joint) -> Sentence:
        axes = AXES[getattr(joint, channel).axes]
        if np.array_equal(axes, -np.eye(3)):
            return f"{code}_sign", f"{word} has the opposite sign", f"negate {', '.join(names)}", names
        where = "world" if channel == "velocity" else "body"
        return (
            f"{code}_axes",
            f"{word} has other axes than the {where}: its columns hold {_axes_text(axes)} of the {where}",
            f"declare the axes of {names[0]}..{names[2]}" + (" (FRD)" if axes[1, 1] == axes[2, 2] == -1 else ""),
            names,
        )

    return sentence


def _removed(joint: Joint) -> Sentence:
    return (
        "acceleration_without_gravity",
        "ax, ay, az hold the acceleration without gravity, not the specific force",
        "add gravity back: a = a + R' (0, 0, g)",
        ("ax", "ay", "az"),
    )


def _axes_text(axes: Array) -> str:
    return ", ".join(("+" if row[k] > 0 else "-") + "xyz"[k] for row in axes for k in [int(np.argmax(np.abs(row)))])


def _world(axes: str) -> str:
    return {"NED": "north-east-down", "z down": "z-down"}.get(axes, axes)


_SENTENCES: dict[str, Callable[[Joint], Sentence]] = {
    "pose.attitude": _attitude,
    "pose.axes": _pose_axes,
    "pose.unit": _pose_unit,
    "pose.down": _pose_down,
    "force.removed": _removed,
    **{f"{c}.turn": _turn(c) for c in _NAMES},
    **{f"{c}.unit": _unit(c) for c in _NAMES},
    **{f"{c}.axes": _axes(c) for c in _NAMES},
}
