"""Clocks that differ: by how much one stream lags another, how sure that is, and whether it stays so.

A stream x, stamped late by tau, satisfies x(t + tau) = y(t) with y what kinematics predicts from the other stream. tau
minimises J(tau), the sum over samples of the whitened squared difference. With J_b its part in block b (1 s), the
standard error is the sandwich sqrt(sum_b J_b'(tau)^2) / J''(tau): it holds under autocorrelation longer than a sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from infotraj.checking.finding import Finding
from infotraj.checking.settings import CHANNEL_OF, command, shift_setting
from infotraj.checking.streams import Stream
from infotraj.rotations import Array

RANGE = 0.3
STEP = 0.005
# An estimate less certain than this says nothing that matters; flights without rotation end here.
MOST_ERROR = 0.02
MOST_UNEXPLAINED = 0.8
TIMES_ERROR = 4.0
SEGMENT = 8


@dataclass(frozen=True)
class Offset:
    """`lag` (s, positive: the stream is stamped late), its standard error, the share of the stream's variance that is
    left unexplained at that lag, the same lag in segments (time, lag, error), and the drift (s/s) with its error."""

    lag: float
    error: float
    unexplained: float
    segments: tuple[tuple[float, float, float], ...]
    drift: float
    drift_error: float

    @property
    def varies(self) -> float:
        """p value of one lag for all segments (Cochran's Q); 1 with fewer than two segments."""
        if len(self.segments) < 2:
            return 1.0
        lag, error = np.array(self.segments).T[1:]
        q = float((((lag - np.average(lag, weights=error**-2)) / error) ** 2).sum())
        return float(special.chdtrc(len(lag) - 1, q))


def offset(stream: Stream, predicted: Array, centres: Array, block: Array, width: float) -> Offset | None:
    """The lag of a stream (k columns) behind its prediction (n, k) at `centres` (n,), averaged over `width`.

    Constant differences (biases) are removed. None where fewer than five blocks remain, where the prediction explains
    less than a fifth of the stream, or where the lag is not known to MOST_ERROR.
    """
    shifts = np.arange(-RANGE, RANGE + STEP / 2, STEP)
    series = np.stack([stream.mean(centres + s, width) for s in shifts])
    good = np.isfinite(series).all(axis=(0, 2)) & np.isfinite(predicted).all(axis=1)
    labels, index = np.unique(block[good], return_inverse=True)
    if len(labels) < 5:
        return None
    x, y = series[:, good], predicted[good]
    x = x - x.mean(axis=1, keepdims=True)
    y = y - y.mean(axis=0)
    rest = x - y
    turned = _turned(x, y) if x.shape[2] == 3 else rest
    # A frame that is turned looks like a lag: what leaves less than half, turned as it fits best, is turned.
    if _least(turned) < 0.5 * _least(rest):
        rest = turned
    first = _squares(rest, index, len(labels))
    best = int(np.argmin(first.sum(axis=(1, 2))))
    noise = (rest[best] ** 2).mean(axis=0) + (1e-3 * x[best].std(axis=0)) ** 2 + 1e-30
    curve = (first / noise).sum(axis=2)
    found = minimum(shifts, curve)
    if found is None:
        return None
    lag, error = found
    at = int(np.argmin(np.abs(shifts - lag)))
    unexplained = float((rest[at] ** 2).sum() / (x[at] ** 2).sum())
    if error > MOST_ERROR or unexplained > MOST_UNEXPLAINED:
        return None
    segments = by_segments(shifts, curve, labels)
    drift, drift_error = line(segments)
    return Offset(lag, error, unexplained, segments, drift, drift_error)


def one_clock(a: Offset | None, b: Offset | None) -> bool:
    """Whether two channels lag by the same, as far as is known of both."""
    return a is not None and b is not None and abs(a.lag - b.lag) < max(TIMES_ERROR * np.hypot(a.error, b.error), STEP)


def offset_findings(
    known: Offset | None,
    what: str,
    behind: str,
    code: str,
    columns: tuple[str, ...],
    step: float,
    tolerated: float,
    along: tuple[str, ...] = (),
) -> list[Finding]:
    """Findings about one lag. `step` (s) is the time between rows; `tolerated` (s) the largest lag that is only noted.
    `along`: columns of another channel of the same clock, which a shift moves as well.

    A lag is reported beyond four standard errors and half a row (and 2.5 ms); one that varies where one lag for all
    segments has p < 1e-4 and the segments differ by more than 20 ms; a drift beyond four standard errors and 10 ms.
    """
    if known is None:
        return []
    found = []
    least = max(0.5 * step, 0.0025)
    ms = 1000 * known.lag
    values = {
        "lag": known.lag,
        "standard_error": known.error,
        "unexplained": known.unexplained,
        "segments": [list(s) for s in known.segments],
        "drift": known.drift,
        "drift_standard_error": known.drift_error,
    }
    late = "late" if known.lag > 0 else "early"
    settings = tuple(shift_setting(CHANNEL_OF[c], known.lag) for c in (columns, along) if c)
    if abs(known.lag) > least and abs(known.lag) > TIMES_ERROR * known.error:
        found.append(
            Finding(
                f"{code}_offset",
                "warning" if abs(known.lag) > tolerated else "note",
                f"{what} is stamped {abs(ms):.1f} +- {1000 * known.error:.1f} ms {late} against {behind}",
                "looks like a delay or a lag of the vehicle; derivatives of one do not fit the other",
                command(settings),
                sure=_sure(abs(known.lag) / max(known.error, 1e-9)),
                channels=columns + along,
                values=values,
                settings=settings,
            )
        )
    lags = [s[1] for s in known.segments]
    if known.varies < 1e-4 and max(lags) - min(lags) > 0.02:
        found.append(
            Finding(
                f"{code}_varies",
                "warning" if tolerated < least else "note",
                f"the lag of {what} behind {behind} varies: {1000 * min(lags):.0f} to {1000 * max(lags):.0f} ms",
                "no single shift puts the streams on one clock",
                "take the quantity from one stream only (derive rates from the attitude)",
                sure=1 - known.varies,
                channels=columns,
                values=values,
            )
        )
    length = known.segments[-1][0] - known.segments[0][0] if known.segments else 0.0
    if abs(known.drift) * length > 0.01 and abs(known.drift) > TIMES_ERROR * known.drift_error:
        found.append(
            Finding(
                f"{code}_drift",
                "warning" if abs(known.drift) * length > tolerated else "note",
                f"the clock of {what} drifts by {1000 * known.drift:.2f} +- {1000 * known.drift_error:.2f} ms a second "
                f"against {behind}",
                "delays that are found at the start do not hold at the end",
                "synchronise the clocks, or stretch the time of one stream",
                sure=_sure(abs(known.drift) / max(known.drift_error, 1e-12)),
                channels=columns,
                values=values,
            )
        )
    return found


def _least(rest: Array) -> float:
    """The least sum of squares (shifts, n, k) over the shifts."""
    return float((rest**2).sum(axis=(1, 2)).min())


def _turned(x: Array, y: Array) -> Array:
    """x (shifts, n, 3) less y (n, 3) turned by the rotation that fits best at each shift (Kabsch 1976)."""
    u, _, v = np.linalg.svd(np.einsum("sni,nj->sij", x, y))
    u[:, :, 2] *= np.sign(np.linalg.det(u @ v))[:, None]
    return x - y @ np.swapaxes(u @ v, 1, 2)


def _squares(rest: Array, index: NDArray[np.intp], blocks: int) -> Array:
    out = np.zeros((rest.shape[0], blocks, rest.shape[2]))
    for b in range(blocks):
        out[:, b] = (rest[:, index == b] ** 2).sum(axis=1)
    return out


def minimum(shifts: Array, curve: Array) -> tuple[float, float] | None:
    """The lag at which the squares of all blocks (shifts, blocks) are least, and its standard error, s."""
    found = _parabola(shifts, curve)
    if found is None:
        return None
    lag, slopes, curvature = found
    n = len(slopes)
    return lag, float(np.sqrt((slopes**2).sum() * n / max(n - 1, 1)) / curvature)


def _parabola(shifts: Array, curve: Array) -> tuple[float, Array, float] | None:
    """The least place of `curve`, the slope of every block there (n,), and the curvature of all together."""
    total = curve.sum(axis=1)
    k = int(np.argmin(total))
    if k < 3 or k > len(shifts) - 4:
        return None
    near = slice(k - 3, k + 4)
    s = shifts[near] - shifts[k]
    # a parabola through seven points: smooth against the noise of single shifts, local against the curve's shape
    fits = np.polyfit(s, curve[near], 2)
    a, b = fits[0].sum(), fits[1].sum()
    if a <= 0:
        return None
    lag = -b / (2 * a)
    return float(shifts[k] + np.clip(lag, s[0], s[-1])), 2 * fits[0] * lag + fits[1], float(2 * a)


def by_segments(shifts: Array, curve: Array, labels: Array) -> tuple[tuple[float, float, float], ...]:
    """Time, lag and standard error of every segment.

    Of a segment's own few blocks an error is rough, and one that is too small by chance makes it differ. What is said
    of all blocks is how much slopes scatter for the curvature that there is (a dispersion, as in quasi-likelihood;
    McCullagh and Nelder, "Generalized linear models", 1989, 9.2), and of each segment its curvature.
    """
    count = len(labels) // SEGMENT
    parts = [
        (part, _parabola(shifts, curve[:, part])) for part in np.array_split(np.arange(len(labels)), max(count, 1))
    ]
    known = [(part, *found) for part, found in parts if found is not None]
    blocks = sum(len(part) for part, *_ in known)
    if blocks <= len(known):
        return ()
    squares = sum(float((slopes**2).sum()) for _, _, slopes, _ in known)
    dispersion = squares / sum(c for *_, c in known) * blocks / (blocks - len(known))
    out = []
    for part, lag, _, curvature in known:
        error = float(np.sqrt(dispersion / curvature))
        if error < MOST_ERROR / 2:
            # never believe less than a fifth of a shift step
            out.append((float(labels[part].mean() + 0.5), lag, max(error, STEP / 5)))
    return tuple(out)


def line(segments: tuple[tuple[float, float, float], ...]) -> tuple[float, float]:
    if len(segments) < 3:
        return 0.0, float("inf")
    t, lag, error = np.array(segments).T
    weight = error**-2
    t = t - np.average(t, weights=weight)
    spread = float((weight * t**2).sum())
    slope = float((weight * t * lag).sum() / spread)
    rest = lag - np.average(lag, weights=weight) - slope * t
    # the scatter about the line counts where it is larger than the errors say
    scale = max(1.0, float((weight * rest**2).sum() / (len(t) - 2)))
    return slope, float(np.sqrt(scale / spread))


def _sure(ratio: ArrayLike) -> float:
    return float(min(0.9999, 1 - 2 * special.ndtr(-np.asarray(ratio))))
