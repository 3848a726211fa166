"""Command against response: the collective command, delayed, against the measured specific force along body z.

The lag that comes out holds the actuators' own lag as well as the clocks'. It cannot be split without a model; but a
response that comes before its command is impossible, and one that comes a quarter of a second later is not a
multirotor.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from infotraj.checking.clocks import Offset, by_segments, line, minimum
from infotraj.checking.finding import Finding
from infotraj.checking.settings import command
from infotraj.checking.streams import Stream
from infotraj.flight import COMMANDED_FORCE, Flight
from infotraj.rotations import Array

RANGE = 0.4
STEP = 0.01
LONGEST = 0.25
USUAL = 0.05  # s, what rotors usually take: assumed where the clocks must be moved


def collective(flight: Flight) -> Stream | None:
    """The collective command (n, 1): commanded force along body z, else the sum of squared rotor commands.

    None where the rotors tilt (their thrust is not along z) or where there is no command.
    """
    if flight.has(*COMMANDED_FORCE):
        x = flight.get("cmd_fz")
    elif flight.numbered("cmd_tilt_").shape[1] == 0 and flight.numbered("cmd_rotor_").shape[1]:
        x = (flight.numbered("cmd_rotor_") ** 2).sum(axis=1, keepdims=True)
    else:
        return None
    good = np.isfinite(x[:, 0])
    if good.sum() < 100:
        return None
    t = flight.t[good]
    return Stream(t, x[good], gap=max(5 * float(np.median(np.diff(t))), 0.05))


def response_lag(
    command: Stream, force_z: Stream, centres: Array, block: Array, width: float, air: Array | None = None
) -> Offset | None:
    """The lag (s) of the force behind the command, or None where the command explains less than a fifth of it.

    air (n, k): what the thrust may go with beside its command, at the centres (n,): inflow and lift go with the speed,
    and would shift the best lag of slow motion by a quarter of a second. It is taken out of both sides.
    """
    shifts = np.arange(-RANGE, RANGE + STEP / 2, STEP)
    y = force_z.mean(centres, width)[:, -1]
    x = np.stack([command.mean(centres - s, width)[:, 0] for s in shifts])
    good = np.isfinite(x).all(axis=0) & np.isfinite(y)
    if air is not None:
        good &= np.isfinite(air).all(axis=1)
    labels, index = np.unique(block[good], return_inverse=True)
    if len(labels) < 5:
        return None
    x, y = _centred(x[:, good], index, len(labels)), _centred(y[good][None], index, len(labels))[0]
    if air is not None:
        beside = np.linalg.qr(_centred(air[good].T, index, len(labels)).T)[0]
        x, y = x - (x @ beside) @ beside.T, y - beside @ (beside.T @ y)
    power = (x**2).sum(axis=1)
    if (power <= 0).any() or (y**2).sum() <= 0:
        return None
    gain = (x @ y) / power
    rest = y - gain[:, None] * x
    noise = float((rest[int(np.argmin((rest**2).sum(axis=1)))] ** 2).mean()) + 1e-30
    curve = np.stack([np.bincount(index, weights=r**2, minlength=len(labels)) for r in rest]) / noise
    found = minimum(shifts, curve)
    if found is None:
        return None
    at = int(np.argmin(np.abs(shifts - found[0])))
    unexplained = float((rest[at] ** 2).sum() / (y**2).sum())
    if unexplained > 0.8 or gain[at] <= 0 or found[1] > 0.03:
        return None
    segments = by_segments(shifts, curve, labels)
    return Offset(found[0], found[1], unexplained, segments, *line(segments))


def response_findings(lag: Offset | None, step: float, channel: str) -> list[Finding]:
    """A response before the command `channel`, or far behind it; otherwise a note with the lag."""
    if lag is None:
        return []
    values = {"lag": lag.lag, "standard_error": lag.error, "unexplained": lag.unexplained}
    text = f"{abs(1000 * lag.lag):.0f} +- {1000 * lag.error:.0f} ms"
    # aerodynamics shift the best lag of slow motion; a clock shifts it in every part of the flight
    everywhere = all(part < 0 for _, part, _ in lag.segments)
    if lag.lag < -max(step, 0.005) and -lag.lag > 4 * lag.error and everywhere:
        settings = (f"{channel}.shift={lag.lag:.3f}",)
        return [
            Finding(
                "response_before_command",
                "warning",
                f"the thrust changes {text} before its command",
                "commands are stamped late: delays and lags of the actuators cannot be learnt",
                command(settings),
                sure=0.999,
                values=values,
                settings=settings,
            )
        ]
    if lag.lag > LONGEST and lag.lag - LONGEST > 4 * lag.error:
        settings = (f"{channel}.shift={lag.lag - USUAL:.3f}",)
        return [
            Finding(
                "response_too_late",
                "warning",
                f"the thrust follows its command only after {text}",
                "no rotor is so slow: the clocks of commands and measurements differ, or the command is not what flew",
                command(settings),
                sure=0.999,
                values=values,
                settings=settings,
            )
        ]
    return [
        Finding(
            "response_lag",
            "note",
            f"the thrust follows its command after {text} (actuators and clocks together)",
            "a clock offset of this size cannot be told from the actuators' lag",
            "nothing",
            values=values,
        )
    ]


def _centred(x: Array, index: NDArray[np.intp], blocks: int) -> Array:
    # slow changes (battery, altitude) are not what a lag shows in: each block has its own mean
    count = np.bincount(index, minlength=blocks)
    mean = np.stack([np.bincount(index, weights=row, minlength=blocks) for row in x]) / count
    return x - mean[:, index]
