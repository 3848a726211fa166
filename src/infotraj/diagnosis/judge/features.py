"""Named quantities along a flight that a residual may depend on, and random features for what has no name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from infotraj import rotation_matrices, rotations
from infotraj.diagnosis.measure.residual import Channel, FlightSamples
from infotraj.models import Prediction
from infotraj.models.interpolation import interpolate
from infotraj.models.recorded import Samples
from infotraj.models.sensor_lag import filtered
from infotraj.rotations import Array

BIN = 0.05  # s: what is looked for is slower than this
LAGS = np.arange(0.1, 1.25, 0.1)  # s: a load that swings answers to what the vehicle did before
_RANDOM = 120
_PLACE, _SPEED = ("px", "py", "pz"), ("vx body", "vy body", "vz body")
_MOTION = (*_PLACE, *_SPEED, "R13", "R23", "R33", "R11", "R21", "wx", "wy", "wz")
_SMOOTH = ((_PLACE, 0.7), (_MOTION, 1.0), (_SPEED, 0.7))  # and lengthscales, of quantities with a variance of 1
_LATELY = (0.1, 0.3)  # s: lags of the speed that a rotor's speed is held against
_SURE = 2.0  # times the usual change of a rotor's speed: which way it goes is plain there


@dataclass(frozen=True)
class Bins:
    """Samples of a channel gathered in bins of 50 ms of one run: number of the bin of each sample, size, mean time."""

    of_sample: Array
    size: Array
    time: Array


def bins(samples: FlightSamples, channel: Channel) -> Bins:
    """The bins of a channel."""
    t = samples.times(channel)
    place = np.floor((t - samples.flight.t[0]) / BIN).astype(int)
    new = np.concatenate([[True], (np.diff(place) != 0) | (np.diff(channel.run) != 0)])
    number = np.cumsum(new) - 1
    size = np.bincount(number).astype(float)
    return Bins(number, size, np.bincount(number, t) / size)


def named(samples: FlightSamples, prediction: Prediction, time: Array) -> dict[str, Array]:
    """Named quantities (N,) at `time` (s): motion, attitude, place, commands, predicted force, time since the start."""
    r = samples.prepared.recorded

    def at(channel: Samples) -> Array:
        return channel.at(time)

    out: dict[str, Array] = {"1": np.ones(len(time))}
    force = interpolate(prediction.t, np.nan_to_num(prediction.specific_force), time)
    out |= {f"predicted f{a}": force[:, i] for i, a in enumerate("xyz")}
    attitude = None
    if r.attitude is not None:
        attitude = rotations.matrix(rotations.normalize(at(r.attitude)))
        out |= {f"R{i + 1}{j + 1}": attitude[:, i, j] for i in range(3) for j in range(3)}
    if r.position is not None:
        out |= {f"p{a}": x for a, x in zip("xyz", at(r.position).T, strict=True)}
    if r.velocity is not None and attitude is not None:
        v = rotation_matrices.turned_back(attitude, at(r.velocity))
        out |= {f"v{a} body": v[:, i] for i, a in enumerate("xyz")}
        out |= {f"|v{a}|v{a} body": np.abs(v[:, i]) * v[:, i] for i, a in enumerate("xyz")}
        out["|v|"] = np.linalg.norm(v, axis=1)
    if r.rate is not None:
        w = at(r.rate)
        out |= {f"w{a}": w[:, i] for i, a in enumerate("xyz")}
        out |= {f"w{a}w{b}": w[:, i] * w[:, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i <= j}
    if samples.prepared.vehicle.rotors:
        out["mean rotor command"] = at(r.rotor).mean(axis=1)
    for i, values in enumerate(at(r.tilt).T):
        out |= {f"sin tilt {i}": np.sin(values), f"cos tilt {i}": np.cos(values)}
    if r.battery is not None:
        out["battery"] = at(r.battery)[:, 0]
    out["t"] = time - samples.flight.t[0]
    return {k: v for k, v in out.items() if np.isfinite(v).all()}


def pasts(samples: FlightSamples, prediction: Prediction, time: Array) -> tuple[Array, ...]:
    """What the vehicle did before, in groups (N, d): its force, its turning, and which way each rotor's input goes."""
    return memory(samples, prediction, time), turning(prediction, time), speeding(samples, time)


def memory(samples: FlightSamples, prediction: Prediction, time: Array) -> Array:
    """Predicted specific force 0.1 to 1.2 s ago, in today's body axes, (N, 3 x lags); none without an attitude."""
    attitude = samples.prepared.recorded.attitude
    if attitude is None:
        return np.zeros((len(time), 0))
    q = rotations.normalize(attitude.at(prediction.t))
    world = rotations.to_world(q, np.nan_to_num(prediction.specific_force))
    now = rotations.normalize(attitude.at(time))
    return np.concatenate(
        [rotations.to_body(now, interpolate(prediction.t, world, time - lag)) for lag in LAGS], axis=1
    )


def turning(prediction: Prediction, time: Array) -> Array:
    """Predicted angular acceleration 0.1 to 1.2 s ago, in the body axes of then, (N, 3 x lags): a load that is carried
    answers to turns, too."""
    turn = np.nan_to_num(prediction.angular_acceleration)
    return np.concatenate([interpolate(prediction.t, turn, time - lag) for lag in LAGS], axis=1)


def speeding(samples: FlightSamples, time: Array) -> Array:
    """Which way each rotor's input goes, -1 to 1, from what it was over 0.1 and 0.3 s, times its square, as a thrust
    grows with it, (N, rotors x 2); (N, 0) where a wrench is commanded.

    A thrust that depends on its past (play, hysteresis, air that follows late) differs between speeds that grow and
    speeds that fall.
    """
    r = samples.prepared.recorded
    if not samples.prepared.vehicle.rotors:
        return np.zeros((len(time), 0))
    speed, steps = r.rotor.at(r.t), np.diff(r.t)
    thrust, out = speed**2 / np.maximum(np.mean(speed**2, axis=0), 1e-12), []
    for lag in _LATELY:
        decay = np.exp(-steps / lag)
        change = speed - filtered(decay, speed, (1.0 - decay)[:, None] * speed[1:])
        way = thrust * np.tanh(_SURE * change / np.maximum(change.std(axis=0), 1e-9))
        out.append((interpolate(r.t, way, time - BIN / 4) + interpolate(r.t, way, time + BIN / 4)) / 2)
    return np.concatenate(out, axis=1)


def smooth(columns: Array, names: Sequence[str], rng: np.random.Generator) -> list[Array]:
    """Random features (N, 120) of standardised quantities (N, d) in groups: place, all motion, and the velocity alone.

    What hangs on few of them is found among few: flights that are alike in how the air meets them are seldom alike in
    all else.
    """
    groups = []
    for group, lengthscale in _SMOOTH:
        own = [k for k, n in enumerate(names) if n in group]
        if own:
            groups.append(random_features(columns[:, own], rng, lengthscale))
    return groups


def random_features(columns: Array, rng: np.random.Generator, lengthscale: float) -> Array:
    """Random Fourier features (N, 120) of standardised columns (N, d): a Gaussian process in their place.

    Rahimi and Recht, "Random features for large-scale kernel machines" (2007), squared exponential kernel.
    """
    d = columns.shape[1]
    frequency = rng.standard_normal((d, _RANDOM)) / (lengthscale * np.sqrt(max(d, 1)))
    return np.cos(columns @ frequency + rng.uniform(0, 2 * np.pi, _RANDOM))
