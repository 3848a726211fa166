"""Gains and limits of the tracking controller, as one flat record that compiled code takes as it is."""

from __future__ import annotations

from typing import NamedTuple

from infotraj.vehicle import NotNegative, Positive


class Gains(NamedTuple):
    """PID gains (per unit error, so that the action is an acceleration) and the limits of what is demanded.

    position, attitude, yaw: 1/s^2, 1/s, 1/s^3; limits: m/s^2 and rad/s^2. A residual model that is wrong in its slope
    multiplies the loop gain (by four, where it took the feedback that held a steady disturbance for an actuator that
    delivers a quarter), so the loops are placed low: roll and pitch, which the rotors drive (lags of 12.5 to 25 ms),
    cross at about 5 rad/s; yaw and the lateral forces wait for the tilts (a servo of 17 rad/s) and cross at about 3.
    """

    position_p: NotNegative = 2.0
    position_d: NotNegative = 2.5
    position_i: NotNegative = 0.4
    attitude_p: NotNegative = 9.0
    attitude_d: NotNegative = 5.0
    attitude_i: NotNegative = 3.0
    yaw_p: NotNegative = 3.0
    yaw_d: NotNegative = 3.0
    yaw_i: NotNegative = 1.0
    max_feedback_acceleration: Positive = 6.0
    max_feedback_angular_acceleration: Positive = 12.0
    max_specific_force: Positive = 20.0
    max_angular_acceleration: Positive = 20.0
    max_correction: Positive = 10.0
