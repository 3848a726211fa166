"""What a flight measured minus what a model predicts, as samples.

force: measured minus predicted specific force. rate: change of the measured rate from sample to sample
minus the integral of the predicted angular acceleration over the same time; its noise is the difference of two samples'
noise, which `Lapped` undoes. velocity: the same of the velocity, in place of `force` where no accelerometer was
measured, or where that is shaken. turn and push: recorded attitude and velocity against the IMU, which show what is
wrong with the IMU alone.

A sensor sampled faster than 200 Hz is taken at that rate, forces as means over the rows between, rates as steps over
them: both sides alike. Above it the filters inside sensors, which no model here has, take away what actuators do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from infotraj import rotation_matrices, rotations
from infotraj.checking.airborne import airborne_rows
from infotraj.effects.channels import from_velocity, is_derived
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model, Prediction
from infotraj.models.prediction import Kinematics
from infotraj.models.prepared import Kept, Prepared
from infotraj.rotations import Array

T = TypeVar("T")
_FEW = 3  # models whose residuals are kept: of the parts of a step that were tried an earlier one may be taken
SETTLING = 0.5  # s after the first row: the actuators start at their first command
_GAP = 4.0  # usual steps; a longer step ends a run
_FINEST = 0.005  # s between samples
AXES = {
    "force": ("fx", "fy", "fz"),
    "velocity": ("vx", "vy", "vz"),
    "rate": ("tx", "ty", "tz"),
    "turn": ("turn x", "turn y", "turn z"),
    "push": ("push x", "push y", "push z"),
}


@dataclass(frozen=True)
class Channel:
    """Samples of one quantity in one flight.

    name; difference: whether the samples are steps between rows (noise is then differenced); first, last (m,) rows of
    each sample; rows (m, n): those that a level's sample is the mean of; run (m,): number of the unbroken stretch that
    a sample belongs to; step: usual time between samples, s.
    """

    name: str
    difference: bool
    first: NDArray
    last: NDArray
    rows: NDArray
    run: NDArray
    step: float

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of its three axes."""
        return AXES[self.name]


@dataclass(frozen=True)
class FlightSamples:
    """The part of a flight that is used, prepared for a vehicle, the channels that can be compared, and the rows left
    out, by reason; logged: the whole of the flight."""

    prepared: Prepared
    channels: tuple[Channel, ...]
    left_out: dict[str, int]
    reasons: dict[str, str]
    logged: Flight

    @property
    def flight(self) -> Flight:
        """The part of it that is used, and a little before and after."""
        return self.prepared.flight

    def residual(self, model: Model) -> list[Array]:
        """Measured minus predicted, one (m, 3) a channel; those of the last few models are kept."""
        return self._last.get("residual", model.key, lambda: self.of_prediction(model.predict(self.prepared)))

    @cached_property
    def _last(self) -> Kept:
        return Kept(_FEW)

    def of_prediction(self, prediction: Prediction) -> list[Array]:
        """Measured minus what this prediction says, one (m, 3) a channel."""
        return [_RESIDUALS[c.name](self, prediction, c) for c in self.channels]

    def times(self, channel: Channel) -> Array:
        """Time (s) of each sample."""
        return self.flight.t[channel.last]


def flight_samples(
    model: Model, flight: Flight, start: float | None = None, stop: float | None = None, clear: float = 0.0
) -> FlightSamples:
    """The flight's usable samples for a model of its vehicle.

    start, stop: s, the part to use; clear: s before and after the ground that are left out.

    InputError where the flight lacks the commands (or measured values) of the vehicle's actuators.
    """
    prepared = model.prepare(flight)
    flight, prediction = prepared.flight, model.predict(prepared)
    t = flight.t
    keep = np.ones(len(t), dtype=bool)
    flying = np.asarray(airborne_rows(flight, model.vehicle).rows, dtype=bool)
    left_out = {}
    for reason, rows in {
        "outside --from and --to": (t < (-np.inf if start is None else start))
        | (t >= (np.inf if stop is None else stop)),
        "first half second": t < t[0] + SETTLING,
        "not in the air": _near(t, ~flying, clear),
        "inputs do not reach": ~np.asarray(prediction.covered, dtype=bool),
    }.items():
        left_out[reason] = int((keep & rows).sum())
        keep &= ~rows
    channels, reasons = [], dict(prediction.kinematics.reasons)
    sources = _sources(prepared, prediction)
    if keep.any():
        prepared = prepared.part(keep, flying)
        first = int(np.searchsorted(t, prepared.flight.t[0]))
        used = slice(first, first + len(prepared.flight.t))
        t, keep = t[used], keep[used]
        sources = {name: (difference, sampled[used], why) for name, (difference, sampled, why) in sources.items()}
    for name, (difference, sampled, why) in sources.items():
        if why is not None:
            reasons[name] = why
            continue
        channel = _channel(name, difference, t, keep, sampled)
        if channel is None:
            reasons[name] = "fewer than 50 usable samples"
        else:
            channels.append(channel)
    return FlightSamples(prepared, tuple(channels), left_out, reasons, flight)


def _near(t: Array, rows: NDArray, within: float) -> NDArray:
    """These rows, and those less than `within` (s) from one of them."""
    if within <= 0.0 or not rows.any():
        return rows
    there = t[rows]
    after = np.clip(np.searchsorted(there, t), 0, len(there) - 1)
    nearest = np.minimum(np.abs(there[after] - t), np.abs(t - there[np.maximum(after - 1, 0)]))
    return np.asarray(nearest < within)


def _sources(prepared: Prepared, prediction: Prediction) -> dict[str, tuple[bool, NDArray, str | None]]:
    """For each channel: whether it is a difference, which rows hold a sample, why it cannot be had (or None)."""
    flight, r = prepared.flight, prepared.recorded
    none = np.zeros(len(flight.t), dtype=bool)

    def finite(*columns: str) -> NDArray:
        return np.asarray(np.isfinite(flight.get(*columns)).all(axis=1)) if flight.has(*columns) else none

    felt = flight.has(*SPECIFIC_FORCE) and not is_derived(flight, SPECIFIC_FORCE)
    mass_reason = None if prepared.vehicle.mass is not None else "the vehicle file gives no mass"
    if any((*prepared.vehicle.center_of_mass, *prepared.vehicle.measured_at)):
        mass_reason = mass_reason or prediction.testable["fx"]
    place = VELOCITY if flight.has(*VELOCITY) else POSITION
    found: dict[str, tuple[bool, NDArray, str | None]] = {}
    if felt and not from_velocity(flight):
        found["force"] = (False, finite(*SPECIFIC_FORCE), mass_reason)
    else:
        why = mass_reason or (None if r.velocity is not None and r.attitude is not None else "no specific force")
        found["velocity"] = (True, finite(*place), why)
    torque_reason = prediction.testable["tx"]
    rated = finite(*RATE) if flight.has(*RATE) else finite(*ATTITUDE)
    found["rate"] = (True, rated, torque_reason)
    k = prediction.kinematics
    if k.turn is not None:
        found["turn"] = (True, finite(*ATTITUDE), None)
    if k.push is not None and not from_velocity(flight):
        found["push"] = (True, finite(*place), None)
    return found


def _channel(name: str, difference: bool, t: Array, keep: NDArray, sampled: NDArray) -> Channel | None:
    rows = np.flatnonzero(keep & sampled)
    if len(rows) < 52:
        return None
    dropped = np.concatenate([[0], np.cumsum(~keep)])
    unbroken = (np.diff(t[rows]) < _GAP * np.median(np.diff(t[rows]))) & (dropped[rows[1:]] == dropped[rows[:-1]])
    run = np.concatenate([[0], np.cumsum(~unbroken)])
    step = float(np.median(np.diff(t[rows])))
    together = max(1, round(_FINEST / step))
    step *= together
    group = _grouped(run, together, difference)
    if not difference:
        group = rows[group]
        made = Channel(name, False, group[:, 0], group[:, -1], group, run[np.searchsorted(rows, group[:, 0])], step)
        return made if len(group) >= 50 else None
    first, last = rows[group[:, 0]], rows[group[:, -1]]
    made = Channel(name, True, first, last, np.zeros((len(first), 0), dtype=int), run[group[:, 0]], step)
    return made if len(first) >= 50 else None


def _grouped(run: NDArray, together: int, difference: bool) -> NDArray:
    """Indices (m, n) of `together` samples in a row of one run, or of the ends and what lies between for a difference.

    Groups follow each other without a gap; what is left at the end of a run is left out.
    """
    starts = np.flatnonzero(np.concatenate([[True], np.diff(run) != 0]))
    counts = np.diff(np.append(starts, len(run)))
    width = together + int(difference)
    firsts = [
        start + together * np.arange(max(0, (count - int(difference)) // together))
        for start, count in zip(starts, counts, strict=True)
    ]
    return np.concatenate(firsts)[:, None] + np.arange(width)


def _steps(t: Array, mean: Array, channel: Channel) -> Array:
    """Integral (m, 3) of `mean` (n, 3), row k from t[k] to t[k+1], over each sample's rows."""
    return _integrals(t, mean, channel.first, channel.last)


@njit(cache=True)
def _integrals(t, mean, first, last):
    total = np.zeros(mean.shape)  # up to each row; of a step that is not known nothing is added
    for k in range(len(t) - 1):
        for j in range(mean.shape[1]):
            x = mean[k, j]
            total[k + 1, j] = total[k, j] + (0.0 if math.isnan(x) else x * (t[k + 1] - t[k]))
    out = np.empty((len(first), mean.shape[1]))
    for i in range(len(first)):
        for j in range(mean.shape[1]):
            out[i, j] = total[last[i], j] - total[first[i], j]
    return out


def _force(samples: FlightSamples, prediction: Prediction, c: Channel) -> Array:
    measured = samples.prepared.kept.get("measured force", None, lambda: _mean(samples.flight.get(*SPECIFIC_FORCE), c))
    return measured - _mean(prediction.specific_force, c)


def _mean(values: Array, c: Channel) -> Array:
    """Mean (m, 3) of values (n, 3) over each sample's rows."""
    return values[c.last] if c.rows.shape[1] == 1 else values[c.rows].mean(axis=1)


def _had(stream: T | None) -> T:
    """What a channel is made of: a channel that exists has it."""
    if stream is None:
        raise TypeError("a channel without its stream")
    return stream


def measured_change(samples: FlightSamples, c: Channel) -> Array:
    """Measured change of the rate (rad/s), (m, 3), over each sample of a rate channel."""
    t, recorded = samples.prepared.recorded.t, _had(samples.prepared.recorded.rate)

    def measured() -> Array:
        given = samples.flight.has(*RATE)
        w = samples.flight.get(*RATE) if given else recorded.at(t)
        return w[c.last] - w[c.first]

    return samples.prepared.kept.get("measured change of rate", None, measured)


def measured_side(samples: FlightSamples, c: Channel) -> Array | None:
    """What was measured (m, 3), in the residual's unit; None for channels of the IMU against itself."""
    if c.name == "force":
        return _mean(samples.flight.get(*SPECIFIC_FORCE), c)
    if c.name == "rate":
        return measured_change(samples, c)
    if c.name == "velocity":
        r = samples.prepared.recorded
        velocity = _had(r.velocity)
        v = velocity.at(r.t)
        # What holds a vehicle up was measured, too: without it a thrust that is wrong by a share would go with nothing.
        fall = samples.prepared.vehicle.gravity * (r.t[c.last] - r.t[c.first])
        return v[c.last] - v[c.first] + np.array([0.0, 0.0, 1.0]) * fall[:, None]
    return None


def _rate(samples: FlightSamples, prediction: Prediction, c: Channel) -> Array:
    t = samples.prepared.recorded.t
    return measured_change(samples, c) - _steps(t, prediction.angular_acceleration_mean, c)


def _velocity(samples: FlightSamples, prediction: Prediction, c: Channel) -> Array:
    r = samples.prepared.recorded
    t = r.t
    kept, velocity, attitude = samples.prepared.kept, _had(r.velocity), _had(r.attitude)

    def turned() -> Array:
        return rotation_matrices.matrices(rotations.normalize(attitude.at(np.append((t[1:] + t[:-1]) / 2, t[-1]))))

    mean = rotation_matrices.turned(kept.get("attitude half way", None, turned), prediction.specific_force_mean)
    v = kept.get("velocity at rows", None, lambda: velocity.at(t))
    return v[c.last] - v[c.first] - _steps(t, mean - [0.0, 0.0, samples.prepared.vehicle.gravity], c)


def _turn(samples: FlightSamples, prediction: Prediction, c: Channel) -> Array:
    k = prediction.kinematics
    return _of_imu(samples, c, k, _had(k.turn), _had(k.turn_by_imu))


def _push(samples: FlightSamples, prediction: Prediction, c: Channel) -> Array:
    k = prediction.kinematics
    return _of_imu(samples, c, k, _had(k.push), _had(k.push_by_imu))


def _of_imu(samples: FlightSamples, c: Channel, of: Kinematics, recorded: Array, by_imu: Array) -> Array:
    """What was recorded minus what the IMU says; the same array while these are, whatever else a model changes."""
    t, kept = samples.prepared.recorded.t, samples.prepared.kept
    made = kept.get(f"recorded {c.name} of samples", None, lambda: _steps(t, recorded, c))
    return kept.get(f"{c.name} left", of.made_of[c.name], lambda: made - _steps(t, by_imu, c))


_RESIDUALS = {"force": _force, "velocity": _velocity, "rate": _rate, "turn": _turn, "push": _push}
