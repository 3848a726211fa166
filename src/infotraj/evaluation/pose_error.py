"""How far a flight is from its reference, in place, in attitude, and in both together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.flight import ATTITUDE, POSITION, REFERENCE_ATTITUDE, REFERENCE_POSITION, Flight
from infotraj.residual.learning_data import SETTLING
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class PoseError:
    """Root mean squares over a flight. position (m); attitude (rad, geodesic); rotors (m): distance of the rotors from
    where the reference puts them, over time and rotors, which holds place and attitude in one length."""

    position: float
    attitude: float
    rotors: float


def pose_error(flight: Flight, vehicle: Vehicle) -> PoseError:
    """The error of the recorded poses, the first 0.5 s left out."""
    rows = flight.get(*POSITION, *ATTITUDE, *REFERENCE_POSITION, *REFERENCE_ATTITUDE)
    kept = rows[np.isfinite(rows).all(axis=1) & (flight.t >= flight.t[0] + SETTLING)]
    place, attitude, wanted, aim = kept[:, :3], kept[:, 3:7], kept[:, 7:10], kept[:, 10:]
    offset = place - wanted
    at = np.array([r.position for r in vehicle.rotors])
    turned = rotations.matrix(attitude) - rotations.matrix(aim)
    rotors = offset[:, None] + np.einsum("nij,rj->nri", turned, at)
    return PoseError(_rms(offset), float(np.sqrt(np.mean(rotations.angle_between(attitude, aim) ** 2))), _rms(rotors))


def _rms(vectors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=-1))))
