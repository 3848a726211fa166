"""Whether the channels follow the pose, axis by axis: the angular velocity the attitude, the velocity the position.

Both sides of an identity are noisy, so a single regression says nothing: noise in what it is told from makes the factor
smaller. The true factor lies between that of the channel on its prediction and that of the reverse regression (Frisch,
"Statistical confluence analysis by means of complete regression systems", 1934). Where both are far from one, on the
same side, no noise explains it: another unit, a mirrored axis, a clock that is far off, or a stream of another flight.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from infotraj.checking.conventions import Verdict
from infotraj.checking.finding import Finding
from infotraj.checking.readings import Identity, Table
from infotraj.checking.settings import CHANNEL_OF, command
from infotraj.flight import RATE, SPECIFIC_FORCE, VELOCITY
from infotraj.importing.streams import noted_setting
from infotraj.rotations import Array

LEAST_FACTOR = 0.7
TIMES_ERROR = 3.0


@dataclass(frozen=True)
class _Channel:
    """How findings about one channel read. `moves`: standard deviation from which an axis moves enough to be judged,
    rad/s, m/s, m/s^2; `goes`: the least correlation with what the others say of it. An accelerometer beside the centre,
    or a noisy pose, has little in common with the other: there only the opposite is told, and no factor."""

    code: str
    what: str
    source: str
    columns: tuple[str, ...]
    moves: float
    goes: float = 0.3
    by_factor: bool = True


_CHANNELS = {
    "rate": _Channel("rates_unexplained", "the angular velocity", "the attitude turns", RATE, 0.25),
    "velocity": _Channel("velocity_unexplained", "the velocity", "the position moves", VELOCITY, 0.2),
    "force": _Channel(
        "acceleration_unexplained", "the specific force", "the pose is accelerated", SPECIFIC_FORCE, 0.3, -0.3, False
    ),
}


def unfollowed(table: Table, verdict: Verdict, notes: Iterable[object] = ()) -> list[Finding]:
    """Channels that do not follow in any reading of units, frames and axes: the verdict's is the best there is.

    `notes`: of the import, which may have seen by the times of recording that a clock is far off.
    """
    found = []
    for name, of in _CHANNELS.items():
        identity = table.identities.get(name)
        if identity is None:
            continue
        reading = getattr(verdict.joint, name)
        # in SI units, by which it is said what moves
        channel, predicted = (x / reading.unit for x in identity.series(verdict.pose, reading))
        factors = [_factor(identity, channel[:, k], predicted[:, k], of) for k in range(3)]
        said = [f"{c} {f}" for c, f in zip(of.columns, factors, strict=True) if f]
        if not said:
            continue
        shifts = (noted_setting(c, "shift", notes) for c in ("rate", "specific_force", "velocity"))
        settings = tuple(filter(None, shifts))
        own = settings if any(s.startswith(f"{CHANNEL_OF[of.columns]}.") for s in settings) else ()
        found.append(
            Finding(
                of.code,
                "reject",
                f"{of.what} is not that by which {of.source}, in any reading of units, frames and axes: "
                f"{', '.join(said)}",
                "what a model is compared with would be this error",
                f"its clock is far off, by the times of recording: {command(own)}"
                if own
                else "check which flight, sensor, unit and clock it is from (clocks are compared to 0.2 s), or leave "
                "it out of the mapping: it is then derived",
                sure=0.99,
                channels=of.columns,
                values={"factors": [f or "follows" for f in factors]},
                settings=own,
            )
        )
    return found


def _factor(identity: Identity, x: Array, p: Array, of: _Channel) -> str:
    """By what factor an axis (n,) follows its prediction (n,), in words; empty where it follows, or hardly moves."""
    block = identity.moments.block
    x, p = x - x.mean(), p - p.mean()
    if p.std() < of.moves:
        return ""
    count = len(identity.moments.labels)
    product, own, told = (np.bincount(block, y, count).astype(float) for y in (x * p, x * x, p * p))

    def ratio(above: Array, below: Array) -> tuple[float, float]:
        value = float(above.sum() / below.sum())
        # errors of means over blocks, which hold under autocorrelation
        return value, float(np.sqrt(((above - value * below) ** 2).sum() * count / (count - 1)) / abs(below.sum()))

    size = float(np.sqrt(own.sum() * told.sum())) / count
    correlation, error = ratio(product, np.full(count, size))
    # Where the channel itself hardly moves, a noisy pose explains that nothing goes with it.
    if x.std() >= of.moves and correlation + TIMES_ERROR * error < of.goes:
        return f"does not go with it (correlation {correlation:.2f})"
    (least, of_least), (most, of_most) = ratio(product, told), ratio(own, product)
    small, large = most + TIMES_ERROR * of_most < LEAST_FACTOR, least - TIMES_ERROR * of_least > 1 / LEAST_FACTOR
    if of.by_factor and ((small and product.sum() > 0) or large):
        return f"is {least:.2g} to {most:.2g} times as large"
    return ""
