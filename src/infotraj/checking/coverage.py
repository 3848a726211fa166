"""What the flights cover: the range and the pace of states and inputs, and what is therefore not excited."""

from __future__ import annotations

from typing import Any

import numpy as np

from infotraj import rotations
from infotraj.checking.finding import Finding
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.rotations import Array, Mask

_HALF = 0.1  # s before and after, of the line that is laid through a path
# Below these the named questions have no answer in practice; stated limits, not tests.
LIMITS: tuple[tuple[str, float, str, str], ...] = (
    ("speed", 1.0, "m/s", "drag"),
    ("tilt", 0.10, "rad", "effects that turn with the attitude"),
    ("rate_x", 0.15, "rad/s", "inertia and damping about x"),
    ("rate_y", 0.15, "rad/s", "inertia and damping about y"),
    ("rate_z", 0.15, "rad/s", "inertia, damping and moment_scale about z"),
    ("vertical_acceleration", 0.3, "m/s^2", "thrust against command, rotor lag"),
    ("height_range", 0.3, "m", "ground effect"),
)


def coverage(flight: Flight, airborne: Mask) -> dict[str, dict[str, Any]]:
    """For each state and input in flight: 1, 50 and 99 % quantiles, root mean square about the mean, and the frequency
    (Hz) below which 90 % of its power lies."""
    rows = flight.table[airborne] if airborne.any() else flight.table
    t = rows["t"].to_numpy(dtype=float)
    series: dict[str, Array] = {}
    groups = [g for g in (POSITION, VELOCITY, RATE, SPECIFIC_FORCE, COMMANDED_WRENCH) if flight.has(*g)]
    columns = [c for g in groups for c in g] + [
        f"{p}{k}" for p in ("cmd_rotor_", "cmd_tilt_", "rotor_", "tilt_") for k in range(flight.numbered(p).shape[1])
    ]
    if flight.has("battery"):
        columns.append("battery")
    for column in columns:
        series[column] = rows[column].to_numpy(dtype=float)
    if flight.has(*ATTITUDE):
        q = rotations.normalize(rows[list(ATTITUDE)].to_numpy(dtype=float))
        series["tilt"] = np.arccos(np.clip(rotations.matrix(q)[:, 2, 2], -1, 1))
        for name, values in zip(("roll", "pitch", "yaw"), rotations.to_euler(q).T, strict=True):
            series[name] = values
    if flight.has(*VELOCITY):
        series["speed"] = np.linalg.norm(rows[list(VELOCITY)].to_numpy(dtype=float), axis=1)
    elif flight.has(*POSITION):
        series["speed"] = _speed(t, rows[list(POSITION)].to_numpy(dtype=float))
    return {name: _describe(t, x) for name, x in series.items() if np.isfinite(x).sum() > 10}


def _speed(t: Array, position: Array) -> Array:
    """Speed (n,) m/s along a path (n, 3): what a straight line over 0.2 s has, of which a millimetre is 7 mm/s."""
    out = np.full(len(t), np.nan)
    seen = np.flatnonzero(np.isfinite(position).all(axis=1))
    if len(seen) > 2:
        far = max(1, round(_HALF / float(np.median(np.diff(t[seen])))))
        before, after = seen[: -2 * far], seen[2 * far :]
        out[seen[far:-far]] = np.linalg.norm(position[after] - position[before], axis=1) / (t[after] - t[before])
    return out


def excitation_findings(covered: dict[str, dict[str, Any]]) -> list[Finding]:
    """One note that lists what these flights cannot teach because nothing moved enough."""
    have = {
        "speed": covered.get("speed", {}).get("q99"),
        "tilt": covered.get("tilt", {}).get("q99"),
        "vertical_acceleration": covered.get("az", {}).get("rms"),
        "height_range": _range(covered.get("pz")),
        **{f"rate_{a}": covered.get(f"w{a}", {}).get("rms") for a in "xyz"},
    }
    weak = [
        (n, value, limit, unit, what)
        for n, limit, unit, what in LIMITS
        if (value := have[n]) is not None and value < limit
    ]
    if not weak:
        return []
    return [
        Finding(
            "not_excited",
            "note",
            "hardly excited: "
            + "; ".join(f"{n} {value:.2g} {unit} (under {limit:g})" for n, value, limit, unit, _ in weak),
            "these flights teach little about " + ", ".join(dict.fromkeys(w[-1] for w in weak)),
            "fly faster, tilt more or turn more where these matter",
            values={n: value for n, value, *_ in weak},
        )
    ]


def _describe(t: Array, x: Array) -> dict[str, Any]:
    good = np.isfinite(x)
    x, t = x[good], t[good]
    low, middle, high = np.percentile(x, [1, 50, 99])
    return {"q01": low, "q50": middle, "q99": high, "rms": float(x.std()), "frequency_90": _pace(t, x)}


def _pace(t: Array, x: Array) -> float:
    step = float(np.median(np.diff(t))) if len(t) > 16 else 0.0
    if step <= 0 or x.std() == 0:
        return 0.0
    grid = np.arange(t[0], t[-1], step)[:65536]
    y = np.interp(grid, t, x)
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(len(y)))) ** 2
    total = np.cumsum(power)
    return float(np.fft.rfftfreq(len(y), step)[int(np.searchsorted(total, 0.9 * total[-1]))])


def _range(entry: dict[str, Any] | None) -> float | None:
    return None if entry is None else float(entry["q99"] - entry["q01"])
