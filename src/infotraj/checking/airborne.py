"""Which rows are in the air: the log's own flag, else motors that carry the vehicle, and height above its rest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.checking.motionless import motionless_rows
from infotraj.checking.streams import runs
from infotraj.flight import COMMANDED_FORCE, Flight
from infotraj.rotations import Array, Mask
from infotraj.vehicle import Vehicle

# A crazyflie's rotors are 5 cm off the ground at rest; below this height above the resting place rows do not count.
CLEARANCE = 0.05
# Half the speed that hovers gives a quarter of the weight: whatever it is, it is not flight.
MOTORS_ON_SHARE = 0.5
# A vehicle without motor channels counts as having rested when it departs this far (m) from a still start or end.
DEPARTURE = 0.15
STILL_SPEED = 0.02
SHORTEST_FLIGHT = 1.0
_SPIKES = 0.05  # of a short log's rows, which do not count as a level that is held
# So long (s) and so high (m) with motors on is a flight, whatever a flag says.
CLEARLY_LONG = 3.0
CLEARLY_HIGH = 0.5


@dataclass(frozen=True)
class Airborne:
    """`rows` (n,) bool; `how` says from what it was judged; `ground` is the height of the resting place, m, or None;
    `against` says what speaks against the log's own flag, and what was believed, or is None."""

    rows: Mask
    how: str
    ground: float | None
    against: str | None = None

    def seconds(self, t: Array) -> float:
        """Time in the air (s); a step longer than ten median steps is a gap and does not count."""
        step = np.diff(t)
        step = np.where(step > 10 * np.median(step), 0.0, step)
        return float(step[self.rows[:-1]].sum())


def airborne_rows(flight: Flight, vehicle: Vehicle | None = None) -> Airborne:
    """The rows in which the vehicle flies.

    The column `airborne` where the log has one, unless motors and height contradict it altogether. Otherwise motors
    (measured, else commanded, else the commanded force) at more than half their flying level and, where there is a
    pose, farther than the clearance (5 cm, with a vehicle file half a rotor radius if that is more) from the height at
    which it stood with motors off. Distance, not height: the sign of z is one of the things to check. Rows in which the
    vehicle stands still with motors that do not change are none. Where nothing tells, every row counts, and `how` says
    so.
    """
    if flight.has("airborne"):
        flag = _filled(flight.get("airborne")[:, 0]) > 0.5
        return _believed(flight, Airborne(flag, "column airborne", None), _judged(flight, vehicle))
    return _judged(flight, vehicle)


def _judged(flight: Flight, vehicle: Vehicle | None) -> Airborne:
    radii = [r.radius for r in vehicle.rotors if r.radius] if vehicle else []
    clearance = max([CLEARANCE, *(0.5 * r for r in radii)])
    motors = _motors_on(flight)
    z = _filled(flight.get("pz")[:, 0]) if flight.has("pz") else None
    standing = motionless_rows(flight)
    if motors is not None:
        on, how = motors
        if (on & standing).any():
            on, how = on & ~standing, f"{how} and motion"
        if z is None or on.all() or not on.any():
            return Airborne(on, how, None)
        ground = float(np.median(z[~on]))
        return Airborne(on & (np.abs(z - ground) > clearance), f"{how} and height", ground)
    if z is not None:
        found = _by_height(flight.t, z, clearance)
        if found.ground is not None or not standing.any():
            return found
    if standing.any():
        return Airborne(~standing, "motion", None)
    return Airborne(np.ones(len(flight.table), dtype=bool), "nothing in the log tells", None)


def _believed(flight: Flight, flag: Airborne, other: Airborne) -> Airborne:
    """The flag, unless it stands still at one value while motors and height clearly say the opposite.

    Height alone does not: an estimator that settles on the ground climbs, too.
    """
    t = flight.t
    if not flag.rows.any() and other.ground is not None and other.how.endswith("and height"):
        high = np.abs(_filled(flight.get("pz")[:, 0]) - other.ground) > CLEARLY_HIGH
        seconds = Airborne(other.rows & high, "", None).seconds(t)
        if seconds > CLEARLY_LONG:
            what = f"the log's flag never says that it flies, {other.how} say so for {other.seconds(t):.1f} s"
            return replace(other, against=f"{what}: they are believed")
    if flag.rows.all() and not other.rows.any() and other.how != "motion":
        what = f"the log's flag says that it flies throughout, {other.how} that it never does"
        return replace(other, against=f"{what}: they are believed")
    return flag


def no_flight(flight: Flight, air: Airborne) -> list[Finding]:
    """A log that never flies, hardly flies, or flies only in ground effect."""
    seconds = air.seconds(flight.t)
    duration = float(flight.t[-1] - flight.t[0])
    contradicted = []
    if air.against is not None:
        contradicted = [
            Finding(
                "airborne_flag",
                "warning",
                air.against,
                "rows on the ground are left out everywhere: a wrong flag leaves out the flight, or counts the ground",
                "leave the flag out of the mapping, or correct it",
                channels=("airborne",),
                values={"judged_from": air.how, "seconds": seconds},
            )
        ]
    if seconds < SHORTEST_FLIGHT:
        what, remedy = f"the vehicle is in the air for {seconds:.1f} s of {duration:.1f} s", "leave this log out"
        if air.rows.all():  # no fault of the flight, but of the part that is used
            what = f"only {duration:.2f} s are used, less than {SHORTEST_FLIGHT:g} s, all of it in the air"
            remedy = "use more of it (--from, --to), or leave this log out"
        return [
            *contradicted,
            Finding(
                "no_flight",
                "reject",
                f"{what} (judged from {air.how})",
                "there is no flight to compare a model with",
                remedy,
                values={"airborne_seconds": seconds, "duration": duration, "judged_from": air.how},
            ),
        ]
    if air.ground is None or not flight.has("pz"):
        return contradicted
    height = np.abs(_filled(flight.get("pz")[:, 0]) - air.ground)[air.rows]
    top = float(np.percentile(height, 99))
    if top < 0.3:
        return [
            *contradicted,
            Finding(
                "low_flight",
                "warning",
                f"the vehicle never rises more than {top:.2f} m above the place where it rested",
                "ground effect and touching the ground are in every row; thrust and drag learnt here hold nowhere else",
                "leave it out unless ground effect is the question",
                values={"height_99": top, "ground": air.ground},
            ),
        ]
    return contradicted


def _motors_on(flight: Flight) -> tuple[Mask, str] | None:
    for prefix, name in (("rotor_", "measured rotors"), ("cmd_rotor_", "commanded rotors")):
        rotors = flight.numbered(prefix)
        if rotors.shape[1] and np.isfinite(rotors).any():
            return _on(flight.t, _filled(_row_mean(np.abs(rotors)))), name
    if flight.has(*COMMANDED_FORCE):
        return _on(flight.t, _filled(np.linalg.norm(flight.get(*COMMANDED_FORCE), axis=1))), "commanded force"
    return None


def _on(t: Array, level: Array) -> Mask:
    # The flying level from the median of the upper half of the range that is held for as long as the shortest flight:
    # spikes and a long stay on the ground, motors idling, do not move it.
    held = SHORTEST_FLIGHT / max(len(t) * np.median(np.diff(t)), SHORTEST_FLIGHT) if len(t) > 1 else 1.0
    top = np.quantile(level, 1.0 - min(held, _SPIKES))
    if top <= 0:
        return np.zeros(len(level), dtype=bool)
    on = level > MOTORS_ON_SHARE * np.median(level[level > 0.5 * top])
    for a, b in runs(~on):
        if a > 0 and b < len(on) and t[b] - t[a] < 0.5:
            on[a:b] = True
    return on


def _by_height(t: Array, z: Array, clearance: float) -> Airborne:
    n = len(t)
    grid = np.arange(t[0], t[-1], 0.25)
    speed = np.abs(np.gradient(np.interp(grid, t, z), 0.25)) if len(grid) > 4 else np.ones(len(grid))
    for end in (slice(0, 3), slice(-3, None)):
        if len(speed) < 8 or not (speed[end] < STILL_SPEED).all():
            continue
        ground = float(np.median(np.interp(grid[end], t, z)))
        far = np.abs(z - ground) > clearance
        if np.percentile(np.abs(z - ground), 90) > DEPARTURE:
            return Airborne(far, "height above a still start or end", ground)
    return Airborne(np.ones(n, dtype=bool), "no motors, no rest on the ground", None)


def _filled(x: Array) -> Array:
    """The last sample held where there is none; the first one before it. Zeros where there is no sample at all."""
    good = np.isfinite(x)
    if not good.any():
        return np.zeros_like(x)
    index = np.maximum.accumulate(np.where(good, np.arange(len(x)), 0))
    out = x[index]
    out[~np.isfinite(out)] = x[np.argmax(good)]
    return out


def _row_mean(x: Array) -> Array:
    count = np.isfinite(x).sum(axis=1)
    total = np.nansum(x, axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
