"""What a model says that the sensors should have measured along a flight."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from numpy.typing import NDArray

from infotraj.rotations import Array

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Recorded motion against what the IMU implies, from t[k] to t[k+1] (last row NaN); shows measurement effects.

    turn (n, 3): mean body rate (rad/s) that turns the recorded attitude of row k into that of row k+1 (rotation vector
    over the step); turn_by_imu: the same from the measured rates, corrected by the model's measurement effects.
    push (n, 3): recorded change of velocity over the step (m/s^2, world); push_by_imu: the same from the measured
    specific force, corrected, and gravity. None where a channel is missing or derived: `reasons` says which, by name.
    made_of: by name, what tells the IMU's side from that of another model.
    """

    turn: Array | None
    turn_by_imu: Array | None
    push: Array | None
    push_by_imu: Array | None
    reasons: dict[str, str]
    made_of: dict[str, Hashable]


@dataclass(frozen=True)
class Prediction:
    """Predicted specific force and angular acceleration at the n rows of a flight, as the IMU would measure them.

    t (n,) s. specific_force (n, 3) m/s^2: at the body's origin, in the IMU's axes (body axes unless the model has
    imu_misalignment), with the accelerometer's bias, at the instant at which row k was sampled (t[k], less a
    time_offset). angular_acceleration (n, 3) rad/s^2: derivative of the measured rate at that instant.
    specific_force_mean (without the bias), angular_acceleration_mean: their means from that instant to the one of row
    k + 1 (last row NaN), so that the measured rate of row k + 1 minus that of row k is (t[k+1] - t[k]) times the mean.
    NaN where the vehicle file does not give mass or inertia.

    covered (n,) bool: False where the inputs do not reach (commands missing for long, motion not recorded); found by
    `reach` when it is first asked for.
    testable: for each of fx fy fz tx ty tz None, or the reason why the prediction or its measured side is missing.
    """

    t: Array
    specific_force: Array
    specific_force_mean: Array
    angular_acceleration: Array
    angular_acceleration_mean: Array
    reach: Callable[[], NDArray]
    testable: dict[str, str | None]
    kinematics: Kinematics

    @cached_property
    def covered(self) -> NDArray:
        """Where the inputs reach, (n,) bool."""
        return self.reach()

    def __getstate__(self) -> dict[str, Any]:
        # What finds it holds the flight.
        return {**self.__dict__, "covered": self.covered, "reach": None}
