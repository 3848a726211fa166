"""Recorded motion against the IMU: what a bias, a misalignment or a time offset of the IMU shows in.

The rotation vector of a step follows from the rates by Magnus' expansion to fourth order (Iserles et al., "Lie-group
methods", 2000): (w1 + w2) h / 2 + sqrt(3)/12 h^2 w1 x w2 with the rates at Gauss' two points, in body axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from infotraj import rotation_matrices, rotations
from infotraj.effects.laws import ImuLaw
from infotraj.models.body import cross
from infotraj.models.prediction import Kinematics
from infotraj.models.prepared import Prepared
from infotraj.models.quieted import fastest
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
    kept = prepared.kept
    if attitude is not None and "turn" not in reasons:
        turn = kept.get("turn", None, partial(_turn, r.t, attitude))
        turn_by_imu = kept.get("turn by IMU", imu.of_rates, partial(_turn_by_imu, prepared, imu, turn))
    if attitude is not None and velocity is not None and "push" not in reasons:
        push = kept.get("push", None, partial(_push, r.t, velocity))
        turned = kept.get("attitude between rows", None, partial(_attitudes, r.t, attitude))
        push_by_imu = kept.get("push by IMU", imu.of_force, partial(_push_by_imu, prepared, imu, push, turned))
    return Kinematics(turn, turn_by_imu, push, push_by_imu, reasons, {"turn": imu.of_rates, "push": imu.of_force})


def _turn_by_imu(prepared: Prepared, imu: ImuLaw, turn: Array) -> Array:
    def made(cut: float) -> Array:
        first, second = (imu.true(x, imu.rate_bias) for x in _measured(prepared, "rate", imu, cut))
        return _turn_of(prepared.recorded.t, first, second)

    return made(_cut(prepared, "turn", turn, made))


def _push_by_imu(prepared: Prepared, imu: ImuLaw, push: Array, turned: list[Array]) -> Array:
    def made(cut: float) -> Array:
        forces = [imu.true(x, imu.force_bias) for x in _measured(prepared, "force", imu, cut)]
        return _push_of(forces, turned, prepared.vehicle.gravity)

    return made(_cut(prepared, "push", push, made))


def _measured(prepared: Prepared, name: str, imu: ImuLaw, cut: float) -> list[Array]:
    """What the IMU measured, at Gauss' first and second point of every step, (n - 1, 3) each."""

    def made() -> list[Array]:
        samples = prepared.measured(name, imu, cut)
        assert samples is not None  # the flight has it
        return [samples.at(x) for x in _gauss(prepared.recorded.t)]

    return prepared.kept.get(f"{name} between rows", (imu.delay, imu.lag, cut), made)


def _cut(prepared: Prepared, name: str, recorded: Array, made: Callable[[float], Array]) -> float:
    """From where on (Hz) what the IMU says of steps is no motion; nowhere where its noise is not left out."""
    if not prepared.quiet:
        return np.inf
    return prepared.kept.get(f"fastest {name}", None, lambda: fastest(prepared.recorded.t, recorded, made(np.inf)))


def _turn(t: Array, attitude: Samples) -> Array:
    q = rotations.normalize(attitude.at(t))
    step = rotations.log(rotations.multiply(rotations.conjugate(q[:-1]), q[1:]))
    return _padded(step / np.diff(t)[:, None])


def _turn_of(t: Array, first: Array, second: Array) -> Array:
    step = np.diff(t)[:, None]
    return _padded(0.5 * (first + second) + np.sqrt(3.0) / 12 * step * cross(first, second))


def _push(t: Array, velocity: Samples) -> Array:
    v = velocity.at(t)
    return _padded(np.diff(v, axis=0) / np.diff(t)[:, None])


def _attitudes(t: Array, attitude: Samples) -> list[Array]:
    """Rotation matrices (n - 1, 3, 3) at Gauss' first and second point of every step."""
    return [rotation_matrices.matrices(rotations.normalize(attitude.at(x))) for x in _gauss(t)]


def _push_of(forces: Sequence[Array], turned: list[Array], gravity: float) -> Array:
    first, second = (rotation_matrices.turned(r, f) for r, f in zip(turned, forces, strict=True))
    return _padded(0.5 * (first + second) - [0.0, 0.0, gravity])


def _gauss(t: Array) -> tuple[Array, Array]:
    half = np.sqrt(3.0) / 6
    return t[:-1] + (0.5 - half) * np.diff(t), t[:-1] + (0.5 + half) * np.diff(t)


def _padded(steps: Array) -> Array:
    return np.concatenate([steps, np.full((1, 3), np.nan)])
