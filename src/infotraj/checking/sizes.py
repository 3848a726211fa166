"""How large a flight is: extents, speeds and rates that flying robots have, whatever the log's units claim.

A reading of the log is possible only where its vehicle moves as one can: no flight takes place within a centimetre, at
300 m/s, or turning 60 times a second. Within these bounds every size is as good as any other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj.checking.kinematics import Channels, velocity_of

# Assumed, and wide on purpose: from a nanodrone that hovers to a fixed wing that crosses a valley.
EXTENT = (0.02, 2e4)  # m, diagonal of the box that holds 90 % of the positions
SPEED = (0.01, 100.0)  # m/s, exceeded in 5 % of the time
RATE = (0.005, 70.0)  # rad/s, the same; the widest gyros end there
FORCE = (2.0, 80.0)  # m/s^2, median


@dataclass(frozen=True)
class Sizes:
    """As declared: the extent of the path, the speed by its positions, and speed, rate and specific force of their own
    channels; NaN where the log does not have them."""

    extent: float
    path_speed: float
    speed: float
    rate: float
    force: float

    @property
    def moves(self) -> bool:
        """Whether a position or a velocity tells how the vehicle moved."""
        return bool(np.isfinite(self.path_speed) or np.isfinite(self.speed))

    def possible(self, position: float, velocity: float, rate: float, force: float) -> bool:
        """Whether a vehicle can move so, given how many times too large each channel is."""
        return all(
            not np.isfinite(size) or low <= size / unit <= high
            for size, unit, (low, high) in (
                (self.extent, position, EXTENT),
                (self.path_speed, position, SPEED),
                (self.speed, velocity, SPEED),
                (self.rate, rate, RATE),
                (self.force, force, FORCE),
            )
        )


def sizes(ch: Channels) -> Sizes:
    """The sizes of one flight's channels as declared."""
    extent = path_speed = float("nan")
    if ch.position is not None and len(ch.centres):
        low, high = np.percentile(ch.position.x, [5, 95], axis=0)
        extent = float(np.linalg.norm(high - low))
        path_speed = _exceeded(velocity_of(ch.position, ch.centres, ch.wide))
    return Sizes(
        extent,
        path_speed,
        _exceeded(ch.velocity.x) if ch.velocity else float("nan"),
        _exceeded(ch.rate.x) if ch.rate else float("nan"),
        float(np.median(np.linalg.norm(ch.force.x, axis=1))) if ch.force else float("nan"),
    )


def _exceeded(x: np.ndarray) -> float:
    size = np.linalg.norm(x, axis=1)
    size = size[np.isfinite(size)]
    return float(np.percentile(size, 95)) if len(size) else float("nan")
