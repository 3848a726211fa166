"""Findings about units, frames and orders: the declared reading against the best of all readings.

The declared reading stands unless, in all logs that share a mapping together,

1. another reading is far better, on each half of the seconds, and a J test with standard errors over 1 s blocks is sure
   of it, with Bonferroni's correction for the number of readings,
2. that reading explains what moves: shrinking a noisy motion to nothing explains noise as well, and is no evidence,
3. a vehicle can move so (`sizes`), and
4. the declared reading fails in absolute terms: an identity that ties two channels is broken by more than sensors in
   order break it (TOLERATED). Where it does not, the finding is a warning: odd, and harmless in this flight. A specific
   force that is in order by this measure is no evidence at all: a poor accelerometer follows many readings.

Otherwise check abstains: a hover does not tell body rates from world rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from infotraj.checking.evidence import Evidence, evidence, together
from infotraj.checking.finding import Finding, Severity
from infotraj.checking.likelihood import AXES
from infotraj.checking.readings import NOISE, PENALTY, Joint, Pose, Table, Vector
from infotraj.checking.sentences import FACTORS, UNITS, WORDS, sentence
from infotraj.checking.settings import command

# What sensors in order leave of an identity, as a vector, over the averaging of `kinematics`.
TOLERATED = {"rate": 0.03, "velocity": 0.05, "force": 0.7}  # rad/s, m/s, m/s^2
FAR_BETTER = float(np.log(3.0))  # of the product of the variances that are left
SURE = 0.99
MOST_UNEXPLAINED = 0.5
NO_WORSE = 1.05  # times the rest as declared, SI units
# A quarter of g: with a larger rest the accelerometer is not understood by any reading.
MOST_FORCE_REST = 2.5
GROSS_SHARE = 0.3
RIVAL = 1.2 * PENALTY
SPOILS = "every comparison of model and measurement would be wrong"


@dataclass(frozen=True)
class Verdict:
    """The joint reading that further checks use, its pose's number, and the findings."""

    joint: Joint
    pose: int
    findings: list[Finding]


@dataclass(frozen=True)
class Decision:
    """What logs that share a mapping say together: the reading they follow instead of the declared one, and why."""

    joint: Joint
    evidence: Evidence


def convention_findings(table: Table) -> Verdict:
    """Judges the declared reading of one log against all others."""
    return verdict(table, decide([table]))


def decide(tables: Sequence[Table]) -> Decision | None:
    """Whether several logs that share a mapping follow another reading than the declared one; None where it stands."""
    tables = [_proven(t) for t in tables]
    for candidate in _candidates(tables):
        kept = _without_unproven(tables, candidate)
        if _changes(kept) and _rejected(tables, Joint(), kept):
            return Decision(kept, _all(tables, Joint(), kept))
    return None


def verdict(table: Table, decision: Decision | None) -> Verdict:
    """The decision as it bears on one of the logs: findings about the channels that it has."""
    if decision is None:
        # a position whose acceleration is noise is no error: the declared reading may have it too
        joint, at = _in(table, Joint())
        return Verdict(joint, at, [])
    found = decision.joint
    joint, at = _in(table, found)
    severity: Severity = "reject" if _fails(decision.evidence, Joint(), found) else "warning"
    present = [f for f in _changes(found) if f.startswith("pose") or f.split(".")[0] in table.identities]
    findings = [_finding(decision.evidence, found, factor, severity) for factor in present]
    rivals = _rivals(table, joint, at)
    if rivals and findings:
        texts = " and ".join
        others = "; or ".join(texts(sorted({sentence(f, j).what for f in _changes(j)})) for j in rivals[:3])
        codes = sorted({sentence(f, j).code for j in rivals for f in _changes(j)})
        first = findings[0]
        findings[0] = replace(
            first,
            what=f"{first.what}; these data fit as well that {others}",
            values={**first.values, "alternatives": codes},
        )
    return Verdict(joint, at, findings)


def _candidates(tables: Sequence[Table]) -> list[Joint]:
    """The best reading of each log, the one that all logs together like best first."""
    best = [_plain(t.best()[0]) for t in tables]
    distinct = [j for k, j in enumerate(best) if _changes(j) and j not in best[:k]]
    return sorted(distinct, key=lambda j: -_all(tables, Joint(), j).gain())


def _in(table: Table, joint: Joint) -> tuple[Joint, int]:
    """The reading in one log: with a position whose acceleration is noise, where that fits the log better."""
    poses = [p for p in (joint.pose, replace(joint.pose, unit=NOISE)) if p in table.poses]
    if joint.pose.unit != 1.0 or not poses:
        poses = [joint.pose] if joint.pose in table.poses else [Pose()]
    value = {p: table.prior[table.poses.index(p)] + _likelihood(table, p, joint) for p in poses}
    pose = max(poses, key=lambda p: value[p])
    return replace(joint, pose=pose), table.poses.index(pose)


def _likelihood(table: Table, pose: Pose, joint: Joint) -> float:
    at = table.poses.index(pose)
    return sum(i.likelihood(at, getattr(joint, name)) for name, i in table.identities.items())


def _all(tables: Sequence[Table], declared: Joint, other: Joint) -> Evidence:
    parts = []
    for table in tables:
        b, bt = _in(table, other)
        # what the position is worth is a fact of the log: both readings take it alike
        pose = replace(declared.pose, unit=NOISE) if b.pose.unit == NOISE else declared.pose
        a = replace(declared, pose=pose) if pose in table.poses else declared
        parts.append(evidence(table, a, table.poses.index(a.pose), b, bt))
    return together(parts)


def _rejected(tables: Sequence[Table], declared: Joint, other: Joint) -> bool:
    still = any(_in(t, other)[0].pose.unit == NOISE or not t.sizes.moves for t in tables)
    if still and _changes(other) == ["force.turn"]:
        # without the motion only gravity is left, and the thrust of fixed rotors looks like gravity in the world frame
        return False
    weighed = _all(tables, declared, other)
    telling = None if _fails(weighed, declared, other) else ("rate", "velocity")
    return weighed.gain(telling) >= FAR_BETTER and weighed.sure >= SURE and _understood(weighed, declared, other)


def _fails(weighed: Evidence, declared: Joint, other: Joint) -> bool:
    """Whether an identity is broken as declared, by more than a rough log breaks it, and mended by the change."""
    return any(
        rest.rms(rest.declared) > TOLERATED[name] and rest.gain() >= FAR_BETTER
        for name, rest in weighed.rests.items()
        if _touched(name, declared, other)
    )


def _understood(weighed: Evidence, declared: Joint, other: Joint) -> bool:
    """Whether the other reading explains what it touches, not by standing still, and no worse in SI units."""
    for name, rest in weighed.rests.items():
        if not _touched(name, declared, other):
            continue
        left = rest.rms(rest.other)
        if left / rest.unit > NO_WORSE * rest.rms(rest.declared):
            return False
        if name == "force":
            # angles that wound round in a wrong unit leave a heading open: what is left is then a small part at least
            if left / rest.unit > MOST_FORCE_REST and left > GROSS_SHARE * rest.rms(rest.declared):
                return False
        elif left**2 > MOST_UNEXPLAINED * rest.rms(rest.motion) ** 2:
            return False
    return True


def _touched(name: str, declared: Joint, other: Joint) -> bool:
    return declared.pose != other.pose or getattr(declared, name) != getattr(other, name)


def _proven(table: Table) -> Table:
    """The table without units of the position that only shrink noise, or that no vehicle can have.

    Noise in a prediction favours smaller ones: at noise as large as the motion, a third of it fits better than all of
    it. A unit is proven where, so read, the position moves as the velocity or the specific force says.
    """
    best, at, _ = table.best()
    if best.pose.unit in (1.0, NOISE):
        return table
    units = (best.pose.unit, best.velocity.unit, best.rate.unit, best.force.unit)
    if table.sizes.possible(*units) and (_follows_velocity(table, best, at) or _follows_force(table, best, at)):
        return table
    allowed = np.array([p.unit in (1.0, NOISE) for p in table.poses])
    return replace(table, prior=np.where(allowed, table.prior, -np.inf))


def _follows_velocity(table: Table, best: Joint, at: int) -> bool:
    identity = table.identities.get("velocity")
    return identity is not None and best.velocity.unit == 1.0 and identity.unexplained(at, best.velocity) < 0.5


def _follows_force(table: Table, best: Joint, at: int) -> bool:
    force = table.identities.get("force")
    noise = replace(best.pose, unit=NOISE)
    if force is None or noise not in table.poses:
        return False
    still, _ = force.residual(table.poses.index(noise), best.force)
    moving, _ = force.residual(at, best.force)
    # by itself, too: a smaller motion in another frame is nearly none, which a poor accelerometer likes
    as_large, _ = force.residual(table.poses.index(replace(best.pose, unit=1.0)), Vector())
    alone, _ = force.residual(at, Vector())
    moves = moving.sum() < MOST_UNEXPLAINED * still.sum()
    return bool(moves and alone.sum() < MOST_UNEXPLAINED * as_large.sum())


def _without_unproven(tables: Sequence[Table], other: Joint) -> Joint:
    # a change that the data do not need (without it, all else the same, the fit is hardly worse) is undone
    for factor in _changes(other):
        simpler = _reset(other, factor)
        if any(simpler.pose not in t.poses for t in tables):
            continue
        weighed = _all(tables, simpler, other)
        if weighed.gain() < FAR_BETTER or weighed.sure < SURE:
            other = simpler
    return other


def _rivals(table: Table, best: Joint, at: int) -> list[Joint]:
    """Other explanations that fit hardly worse and take at most one change more: what this flight cannot tell apart."""
    found: list[Joint] = []
    value = table.prior[at] + sum(
        i.likelihood(at, getattr(best, n)) - getattr(best, n).penalty for n, i in table.identities.items()
    )
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
        if fresh and total > value - RIVAL and evidence(table, joint, k, best, at).gain() < FAR_BETTER:
            found.append(joint)
    return found


def _what(joint: Joint) -> list[tuple[str, object]]:
    return [(factor, _part(joint, factor)) for factor in _changes(joint)]


def _changes(joint: Joint) -> list[str]:
    plain = Joint()
    return [f for f in FACTORS if _part(joint, f) != _part(plain, f) and _part(joint, f) != NOISE]


def _plain(joint: Joint) -> Joint:
    return replace(joint, pose=replace(joint.pose, unit=1.0)) if joint.pose.unit == NOISE else joint


def _part(joint: Joint, factor: str) -> object:
    channel, key = factor.split(".")
    return getattr(getattr(joint, channel), key)


def _reset(joint: Joint, factor: str) -> Joint:
    channel, key = factor.split(".")
    plain = getattr(getattr(Joint(), channel), key)
    return replace(joint, **{channel: replace(getattr(joint, channel), **{key: plain})})


def _finding(weighed: Evidence, found: Joint, factor: str, severity: Severity) -> Finding:
    said = sentence(factor, found)
    rests = {n: r for n, r in weighed.rests.items() if factor.startswith(("pose", n))}
    numbers = "; ".join(
        f"{WORDS[n]}: as declared it differs from what the other channels say by {r.rms(r.declared):.2g} {UNITS[n]}, "
        f"as corrected by {r.rms(r.other) / r.unit:.2g}"
        # in a smaller unit everything is small: what counts is how small beside the motion
        + (f" where it moves by {r.rms(r.motion) / r.unit:.2g}" if r.unit != 1.0 else "")
        for n, r in rests.items()
        if r.gain() > 0.1
    )
    return Finding(
        said.code,
        severity,
        f"{said.what} ({numbers})" if numbers else said.what,
        SPOILS,
        command(said.settings),
        sure=min(weighed.sure, 0.9999),
        channels=said.channels,
        values={n: {"as_declared": r.rms(r.declared), "as_found": r.rms(r.other) / r.unit} for n, r in rests.items()},
        settings=said.settings,
    )
