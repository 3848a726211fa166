"""Gains and limits of the tracking controller, as one flat record that compiled code takes as it is."""

from __future__ import annotations

from typing import NamedTuple


class Gains(NamedTuple):
    """PID gains (per unit error, so that the action is an acceleration) and the limits of what is demanded.

    position: 1/s^2, 1/s, 1/s^3; attitude: 1/s^2, 1/s, 1/s^3; limits: m/s^2 and rad/s^2. The defaults place the
    position loop at 1.7 rad/s and the attitude loop at 4 rad/s, well below the servo's 17 rad/s.
    """

    position_p: float = 3.0
    position_d: float = 3.0
    position_i: float = 0.4
    attitude_p: float = 16.0
    attitude_d: float = 8.0
    attitude_i: float = 4.0
    max_feedback_acceleration: float = 6.0
    max_feedback_angular_acceleration: float = 12.0
    max_specific_force: float = 20.0
    max_angular_acceleration: float = 20.0
    max_correction: float = 10.0
