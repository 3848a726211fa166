"""Recorded motion against the IMU: what a bias, a misalignment or a time offset of the IMU shows in.

The rotation vector of a step follows from the rates by Magnus' expansion to fourth order (Iserles et al., "Lie-group
methods", 2000): (w1 + w2) h / 2 + sqrt(3)/12 h^2 w1 x w2 with the rates at Gauss' two points, in body axes.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from infotraj import rotation_matrices, rotations
from infotraj.effects.laws import ImuLaw
from infotraj.models.body import cross
from infotraj.models.prediction import Kinematics
from infotraj.models.prepared import Prepared
from infotraj.models.quieted import fastest, quieted
from infotraj.models.recorded import Samples
from infotraj.rotations import Array


def kinematics(prepared: Prepared, imu: ImuLaw) -> Kinematics:
    """Turn and push of every step of a flight, as recorded and as the corrected IMU implies them."""
    r = prepared.recorded
    reasons: dict[str, str] = {}
    if r.attitude is None or r.attitude.derived:
        reasons["turn"] = "the flight has no attitude of its own"
    elif r.rate is None or r.rate.derived:
        reasons["turn"] = "the rates are derived from the attitude, not measured"
    if r.velocity is None or r.attitude is None:
        reasons["push"] = "the flight has neither velocity nor position, or no attitude"
    elif r.specific_force is None or r.specific_force.derived:
        reasons["push"] = "the flight has no measured specific force"
    turn = turn_by_imu = push = push_by_imu = None
    attitude, velocity = r.attitude, r.velocity
    rate = None if "turn" in reasons else prepared.true_rate(imu)
    force = None if "push" in reasons else prepared.true_specific_force(imu)
    kept = prepared.kept
    if attitude is not None and rate is not None:
        turn = kept.get("turn", None, partial(_turn, r.t, attitude))
        turn_by_imu = kept.get("turn by IMU", imu.of_rates, partial(_quiet_turn, prepared, turn, rate))
    if attitude is not None and velocity is not None and force is not None:
        push = kept.get("push", None, partial(_push, r.t, velocity))
        turned = kept.get("attitude between rows", None, partial(_attitudes, r.t, attitude))
        push_by_imu = kept.get("push by IMU", imu.of_force, partial(_quiet_push, prepared, push, turned, force))
    return Kinematics(turn, turn_by_imu, push, push_by_imu, reasons, {"turn": imu.of_rates, "push": imu.of_force})


def _quiet_turn(prepared: Prepared, turn: Array, rate: Samples) -> Array:
    t = prepared.recorded.t
    by_imu = _turn_by_imu(t, rate)
    if not prepared.quiet:
        return by_imu
    cut = prepared.kept.get("fastest turn", None, partial(fastest, t, turn, by_imu))
    return _turn_by_imu(t, quieted(rate, cut))


def _quiet_push(prepared: Prepared, push: Array, turned: list[Array], force: Samples) -> Array:
    t, gravity = prepared.recorded.t, prepared.vehicle.gravity
    by_imu = _push_by_imu(t, force, turned, gravity)
    if not prepared.quiet:
        return by_imu
    cut = prepared.kept.get("fastest push", None, partial(fastest, t, push, by_imu))
    return _push_by_imu(t, quieted(force, cut), turned, gravity)


def _turn(t: Array, attitude: Samples) -> Array:
    q = rotations.normalize(attitude.at(t))
    step = rotations.log(rotations.multiply(rotations.conjugate(q[:-1]), q[1:]))
    return _padded(step / np.diff(t)[:, None])


def _turn_by_imu(t: Array, rate: Samples) -> Array:
    step = np.diff(t)[:, None]
    first, second = (rate.at(x) for x in _gauss(t))
    return _padded(0.5 * (first + second) + np.sqrt(3.0) / 12 * step * cross(first, second))


def _push(t: Array, velocity: Samples) -> Array:
    v = velocity.at(t)
    return _padded(np.diff(v, axis=0) / np.diff(t)[:, None])


def _attitudes(t: Array, attitude: Samples) -> list[Array]:
    """Rotation matrices (n - 1, 3, 3) at Gauss' first and second point of every step."""
    return [rotation_matrices.matrices(rotations.normalize(attitude.at(x))) for x in _gauss(t)]


def _push_by_imu(t: Array, force: Samples, turned: list[Array], gravity: float) -> Array:
    first, second = (rotation_matrices.turned(r, force.at(x)) for r, x in zip(turned, _gauss(t), strict=True))
    return _padded(0.5 * (first + second) - [0.0, 0.0, gravity])


def _gauss(t: Array) -> tuple[Array, Array]:
    half = np.sqrt(3.0) / 6
    return t[:-1] + (0.5 - half) * np.diff(t), t[:-1] + (0.5 + half) * np.diff(t)


def _padded(steps: Array) -> Array:
    return np.concatenate([steps, np.full((1, 3), np.nan)])
