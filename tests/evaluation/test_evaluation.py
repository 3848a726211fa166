"""Errors of poses, and what a choice from a pool was worth, by cases that can be computed by hand."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from infotraj.evaluation.pool_choice import choices
from infotraj.evaluation.pose_error import pose_error
from infotraj.flight import ATTITUDE, POSITION, REFERENCE_ATTITUDE, REFERENCE_POSITION, Flight
from infotraj.vehicle import load_vehicle

QUADROTOR = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")


def test_rotors_are_off_by_their_arm_times_the_turn_whatever_the_attitude():
    """On its side, and turned by 0.2 rad about the body's own z: each rotor moves along a chord about that axis."""
    half, turn = np.sqrt(0.5), 0.2
    aim = np.array([half, half, 0.0, 0.0])
    z = np.array([np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)])
    w, x = aim[0], aim[1]
    attitude = np.array([w * z[0], x * z[0], -x * z[3], w * z[3]])  # aim times z
    t = np.arange(0.0, 2.0, 0.01)
    rows = dict(zip(ATTITUDE, attitude, strict=True)) | dict(zip(REFERENCE_ATTITUDE, aim, strict=True))
    rows |= dict.fromkeys((*POSITION, *REFERENCE_POSITION), 0.0)
    error = pose_error(Flight(pd.DataFrame({"t": t} | rows)), QUADROTOR)
    arms = [np.hypot(*r.position[:2]) for r in QUADROTOR.rotors]
    assert error.position == 0.0
    assert error.attitude == pytest.approx(turn)
    assert error.rotors == pytest.approx(2 * np.sin(turn / 2) * np.sqrt(np.mean(np.square(arms))))


def test_a_choice_stands_beside_the_median_the_mean_and_the_best():
    table = pd.DataFrame(
        {
            "task": "a",
            "prior": "b",
            "candidate": ["1", "2", "3", "4", "5"],
            "seed": 0,
            "cost": [1.0, 2.0, 3.0, 4.0, 5.0],
            "error": [2.0, 1.0, 3.0, 4.0, 20.0],
            "chosen": [1, 0, 0, 0, 0],
        }
    )
    (row,) = choices(table).to_dict("records")
    assert (row["chosen"], row["median"], row["random"], row["best"], row["rank"]) == (2.0, 3.0, 6.0, 1.0, 2)
