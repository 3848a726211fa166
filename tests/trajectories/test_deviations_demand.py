"""What a reference would ask of rotors, against the same wrench worked out by differences."""

import numpy as np
import pytest

from infotraj import rotations
from infotraj.dynamics.allocation import Allocation
from infotraj.trajectories.deviations import demand
from infotraj.trajectories.reference import from_poses
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")


def test_a_turning_body_asks_for_the_change_of_its_angular_momentum():
    """In world axes the torque is d(R J w)/dt: the gyroscopic part with its sign."""
    t = 0.005 * np.arange(800)
    angles = np.stack([0.9 * np.sin(5 * t), 0.9 * np.sin(4 * t + 1), 0.9 * np.sin(6 * t + 2)], axis=1)
    reference = from_poses(t, np.zeros((len(t), 3)), rotations.exp(angles))
    spread = OMAV.model_copy(
        update={
            "inertia": OMAV.inertia.model_copy(update={"xx": 0.05, "yy": 0.4, "zz": 0.9, "xy": 0, "xz": 0, "yz": 0})
        }
    )
    momentum = rotations.to_world(reference.attitude, reference.rate @ spread.inertia_matrix())
    torque = rotations.to_body(reference.attitude, np.gradient(momentum, t, axis=0))
    force = OMAV.mass * rotations.to_body(reference.attitude, np.broadcast_to([0.0, 0.0, OMAV.gravity], (len(t), 3)))
    allocation = Allocation(spread)
    inside = slice(10, -10)
    speed, _ = allocation.actuators(np.concatenate([force, torque], axis=1)[inside])
    share = np.max(speed / [r.max_speed for r in OMAV.rotors])
    assert demand(reference, allocation)[0] == pytest.approx(share, rel=0.01)


def test_a_flight_backwards_asks_the_tilts_for_the_same_rate():
    """In yaw all tilts turn one way at a time: of the two ways the faster one counts, whichever comes first."""
    t = 0.01 * np.arange(600)
    yaw = 0.4 * (np.sin(2.0 * t) + 0.5 * np.sin(4.0 * t))
    both = [from_poses(t, np.zeros((len(t), 3)), rotations.from_euler(0 * t, 0 * t, x)) for x in (yaw, yaw[::-1])]
    forth, back = (demand(reference, Allocation(OMAV))[1] for reference in both)
    assert forth == pytest.approx(back, rel=1e-3)
    assert forth > 0.01
