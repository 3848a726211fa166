"""Values that cannot be: spikes, clipped sensors, commands out of range, quaternions that are no rotation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from infotraj.checking.finding import Finding, Severity, Span, spans_text
from infotraj.checking.percent import percent
from infotraj.checking.streams import runs
from infotraj.checking.voids import Void
from infotraj.flight import ATTITUDE, COMMANDED_FORCE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array, Mask
from infotraj.vehicle import Vehicle

# Gyros of flight controllers end at 2000 deg/s (35 rad/s), the widest at 4000 deg/s (70 rad/s).
FASTEST_RATE = 70.0
FASTEST_SPEED = 150.0
LARGEST_FORCE = 500.0
SPIKE_SCALES = 30.0
TAIL_SCALES = 5.0
SPIKE_OF_RANGE = 0.25
FEW = 0.01


def attitude_norm(flight: Flight) -> list[Finding]:
    """Quaternions whose length is not 1 (by more than 1 %): zeros, or columns that hold something else."""
    if not flight.has(*ATTITUDE):
        return []
    q = flight.get(*ATTITUDE)
    good = np.isfinite(q).all(axis=1)
    norm = np.linalg.norm(q, axis=1)
    bad = good & (np.abs(norm - 1) > 0.01)
    share = float(bad.sum() / max(good.sum(), 1))
    if not share:
        return []
    worthless = share > 0.05
    return [
        Finding(
            "attitude_norm",
            "reject" if worthless else "note",
            f"the quaternion has a length other than 1 in {percent(share)} of the rows "
            f"(median {np.median(norm[bad]):.3g})",
            "it is no attitude there",
            "check which columns are the quaternion" if worthless else "leave these rows out",
            spans=() if worthless else _spans(flight.t, bad),
            channels=ATTITUDE,
            values={"share": share},
            drop=not worthless,
        )
    ]


def impossible_values(flight: Flight, airborne: Mask) -> list[Finding]:
    """Rates, speeds and forces that no multirotor and no sensor reaches, in more than 1 % of the flight."""
    found = []
    for columns, limit, unit, code, hint in (
        (
            RATE,
            FASTEST_RATE,
            "rad/s",
            "rate_impossible",
            "check the unit: 70 rad/s is the end of the widest gyro, deg/s?",
        ),
        (VELOCITY, FASTEST_SPEED, "m/s", "speed_impossible", "check the unit (mm/s?) and the estimator"),
        (SPECIFIC_FORCE, LARGEST_FORCE, "m/s^2", "force_impossible", "check the unit: is it counts, or mg?"),
    ):
        if not flight.has(*columns):
            continue
        size = np.nan_to_num(np.linalg.norm(flight.get(*columns), axis=1))
        bad = (size > limit) & airborne
        share = float(bad.sum() / max(airborne.sum(), 1))
        if share > FEW:
            found.append(
                Finding(
                    code,
                    "reject",
                    f"{columns[0]}..{columns[2]} exceed {limit:g} {unit} in {percent(share)} of the flight",
                    "every comparison of model and measurement would be wrong",
                    hint,
                    sure=0.99,
                    channels=columns,
                    values={"share": share, "largest": float(size[airborne].max())},
                )
            )
    return found


def spikes(flight: Flight, airborne: Mask) -> list[tuple[str, tuple[Span, ...], float]]:
    """Channels with single samples (at most two in a row) far from their neighbours on both sides, in flight.

    For each: the column, when, and the share of its samples.

    Far from the running median of five (Hampel): by 30 times the channel's robust scatter about it, by five times what
    one sample in two hundred shows (heavy tails are not spikes), and by a quarter of the channel's range. A value that
    is held over several rows counts as one sample.
    """
    found = []
    for column in flight.table.columns:
        if column == "t" or column.startswith("ref_") or column == "airborne":
            continue
        x = flight.get(column)[:, 0]
        good = np.flatnonzero(np.isfinite(x) & airborne)
        if len(good) < 100:
            continue
        new = np.concatenate([[True], np.diff(x[good]) != 0])
        first = np.flatnonzero(new)
        past = np.append(first[1:], len(good))
        samples = _spikes(x[good][first]) if len(first) >= 50 else np.empty(0, dtype=np.int_)
        if column.startswith("cmd_"):
            # a command that is held for a while was meant
            samples = samples[past[samples] - first[samples] <= 2]
        if len(samples):
            when = tuple((float(flight.t[good[first[k]]]), float(flight.t[good[past[k] - 1]])) for k in samples)
            found.append((column, when, len(samples) / len(first)))
    return found


def spike_findings(found: list[tuple[str, tuple[Span, ...], float]]) -> list[Finding]:
    """One finding for all channels with spikes; a warning where one of them has more than 1 %."""
    if not found:
        return []
    worst = max(share for _, _, share in found)
    counts = {column: len(when) for column, when, _ in found}
    spans = tuple(sorted({span for _, when, _ in found for span in when}))
    return [
        Finding(
            "spikes",
            "warning" if worst > FEW else "note",
            f"single wrong samples in {', '.join(f'{c} ({n})' for c, n in counts.items())} at {spans_text(spans, 3)}",
            "they weigh like hundreds of good ones in a squared error",
            "leave these samples out, or use a robust fit",
            spans=spans,
            channels=tuple(counts),
            values={"counts": counts, "largest_share": worst},
        )
    ]


def spike_voids(flight: Flight, found: list[tuple[str, tuple[Span, ...], float]]) -> list[Void]:
    """The samples that are spikes."""
    t = flight.t
    at = {column: np.any([(t >= a) & (t <= b) for a, b in when], axis=0) for column, when, _ in found}
    return [Void("spikes", (column,), t[rows]) for column, rows in at.items()]


def saturation(flight: Flight, airborne: Mask) -> tuple[list[Finding], list[Void]]:
    """Channels that stay at their own extreme for three samples or more, again and again, in flight; and the samples
    of sensors there, which say only that the true value lies beyond."""
    found, voids = [], []
    commands = [
        f"{p}{k}" for p in ("cmd_rotor_", "cmd_tilt_", "rotor_", "tilt_") for k in range(flight.numbered(p).shape[1])
    ]
    sensors = [c for g in (RATE, SPECIFIC_FORCE) if flight.has(*g) for c in g]
    for column in (*sensors, *commands):
        x = flight.get(column)[:, 0]
        keep = np.isfinite(x) & airborne
        if keep.sum() < 100 or np.ptp(x[keep]) == 0:
            continue
        rows = np.zeros(len(x), dtype=bool)
        usual = _usual_repeat(x[keep])
        for extreme in (x[keep].min(), x[keep].max()):
            if column in commands and extreme == 0.0:
                continue
            at = keep & (x == extreme)
            if not _piled(x[keep], extreme):
                continue
            long = [r for r in runs(at) if r[1] - r[0] >= 3 * usual]
            if len(long) >= 2:
                for a, b in long:
                    rows[a:b] = True
        share = float(rows.sum() / keep.sum())
        if share > 0.002:
            sensor = column in sensors
            if sensor:
                voids.append(Void("saturated", (column,), flight.t[rows]))
            severity: Severity = "warning" if sensor and share > FEW else "note"
            spans = _spans(flight.t, rows)
            found.append(
                Finding(
                    "saturated",
                    severity,
                    f"{column} stays at its extreme for {percent(share)} of the flight ({spans_text(spans, 2)})",
                    "the true value lies beyond it: these samples are left empty"
                    if sensor
                    else "the actuator could not do more: models differ least here",
                    "use a wider range" if sensor else "none, unless the limit is not in the vehicle file",
                    spans=spans,
                    channels=(column,),
                    values={"share": share},
                )
            )
    return found, voids


def impossible_commands(flight: Flight, airborne: Mask, vehicle: Vehicle | None) -> list[Finding]:
    """Rotor commands below zero or beyond full scale, and commanded forces far beyond what flies."""
    rotors = flight.numbered("cmd_rotor_")
    found = []
    if rotors.shape[1] and np.isfinite(rotors).any():
        top = _full_scale(rotors, vehicle)
        speeds = top > 1.0 and (vehicle is None or all(r.input == "speed" for r in vehicle.rotors))
        rotors = np.abs(rotors) if speeds else rotors  # a speed's sign says which way the rotor turns
        with np.errstate(invalid="ignore"):
            bad = np.any((rotors < -0.01 * top) | (rotors > 1.02 * top), axis=1)
        if bad.any():
            columns = tuple(f"cmd_rotor_{k}" for k in range(rotors.shape[1]))
            extremes = (float(np.nanmin(rotors)), float(np.nanmax(rotors)))
            found.append(
                _commands(
                    flight, bad, airborne, columns, f"outside 0..{top:.4g}: {extremes[0]:.4g} to {extremes[1]:.4g}"
                )
            )
    if flight.has(*COMMANDED_FORCE):
        size = np.linalg.norm(flight.get(*COMMANDED_FORCE), axis=1)
        usual = np.nanmedian(size[airborne]) if airborne.any() else np.nanmedian(size)
        with np.errstate(invalid="ignore"):
            bad = size > 10 * usual
        if usual > 0 and bad.any():
            found.append(
                _commands(flight, bad, airborne, COMMANDED_FORCE, f"more than ten times the usual {usual:.3g} N")
            )
    return found


def pose_jumps(flight: Flight, airborne: Mask) -> list[Finding]:
    """Positions that jump between neighbouring samples: a lost marker, a reset of the estimator."""
    if not flight.has(*POSITION):
        return []
    p = flight.get(*POSITION)
    good = np.flatnonzero(np.isfinite(p).all(axis=1) & airborne)
    if len(good) < 20:
        return []
    step, dt = np.diff(p[good], axis=0), np.diff(flight.t[good])
    speed = np.linalg.norm(step, axis=1) / dt
    limit = max(20.0, 20 * float(np.percentile(speed, 99)))
    bad = np.flatnonzero((speed > limit) & (dt < 10 * np.median(dt)))
    if not len(bad):
        return []
    at = flight.t[good[bad]]
    return [
        Finding(
            "pose_jump",
            "warning",
            f"the position jumps {len(bad)} times, "
            f"by up to {np.linalg.norm(step[bad], axis=1).max():.3g} m in one sample",
            "velocity and acceleration are wrong at the jump, and rollouts across it",
            "cut the log there",
            spans=tuple((float(a), float(a)) for a in at),
            channels=POSITION,
            values={"count": len(bad)},
        )
    ]


def _commands(flight: Flight, bad: Mask, airborne: Mask, columns: tuple[str, ...], text: str) -> Finding:
    share = float((bad & airborne).sum() / max(airborne.sum(), 1))
    spans = _spans(flight.t, bad)
    return Finding(
        "impossible_command",
        "warning" if share > FEW else "note",
        f"{columns[0]}..{columns[-1]} are {text} ({spans_text(spans)})",
        "no actuator received such a command",
        "leave these rows out; check the unit",
        spans=spans,
        channels=columns,
        values={"share_of_flight": share},
        drop=share <= FEW,
    )


def _full_scale(rotors: Array, vehicle: Vehicle | None) -> float:
    given = vehicle.rotors if vehicle else ()
    if given and given[0].input == "throttle":
        return 1.0
    limits = [r.max_speed for r in given if r.max_speed]
    if limits and given[0].input == "thrust":
        return max(r.known_thrust_coefficient() * r.max_speed**2 for r in given if r.max_speed)
    if limits:
        return float(max(limits))
    # without a vehicle: most samples at or below 1 are a throttle; speeds have no scale that is known
    usual = float(np.nanpercentile(np.abs(rotors), 90))
    return 1.0 if usual <= 1.0 else 20 * usual


def _spikes(x: Array) -> NDArray[np.int_]:
    away = np.zeros(len(x))
    away[2:-2] = np.abs(x[2:-2] - np.median(np.lib.stride_tricks.sliding_window_view(x, 5), axis=1))
    moving = away[away > 0]
    if not len(moving):
        return np.empty(0, dtype=np.int_)
    scale = 1.4826 * float(np.median(moving))
    low, high = np.percentile(x, [5, 95])
    limit = max(SPIKE_SCALES * scale, TAIL_SCALES * float(np.percentile(away, 99.5)), SPIKE_OF_RANGE * (high - low))
    return np.array([k for a, b in runs(away > limit) if b - a <= 2 for k in range(a, b)], dtype=int)


def _piled(x: Array, extreme: float) -> bool:
    # what is clipped piles up at the last value; what is merely written in steps gets rarer towards it
    values, counts = np.unique(x, return_counts=True)
    end, beside = (0, 1) if extreme == values[0] else (-1, -2)
    return bool(counts[end] > 2 * counts[beside])


def _usual_repeat(x: Array) -> int:
    same = np.diff(x) == 0
    lengths = [b - a + 1 for a, b in runs(same)]
    # streams held between samples repeat by design
    return max(1, int(np.median(lengths))) if same.mean() > 0.3 and lengths else 1


def _spans(t: Array, rows: Mask) -> tuple[Span, ...]:
    return tuple((float(t[a]), float(t[b - 1])) for a, b in runs(rows))
