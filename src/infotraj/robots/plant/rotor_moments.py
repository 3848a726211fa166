"""What rotors do to the body beside thrust, reaction torque and drag: angular momentum, flapping, rolling. Compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.robots.plant.rotor_air import rotor_air


@njit(cache=True, error_model="numpy")
def gyroscopic(rotors, axes, slope, command, square, rate, direction, wrench):
    """Adds the torque -omega x H - dH/dt (derivative in body axes), H = sum of inertia spin w d, to `wrench` (6,).

    slope (tilts,) rad/s: how fast the arms turn about `axes`; command (rotors,) rad/s; square (rotors,) speeds squared.
    """
    if rotors[0].inertia == 0.0:
        return
    h, change = np.zeros(3), np.zeros(3)
    for i in range(rotors.shape[0]):
        r, d = rotors[i], direction[i]
        spin, w = r.spin, np.sqrt(square[i])
        target = min(max(command[i], 0.0), r.max_speed)
        lag = r.rise if w < target else r.fall
        gain = (target - w) / lag if lag > 0.0 else 0.0
        for c in range(3):
            h[c] += r.inertia * spin * w * d[c]
            change[c] += r.inertia * spin * gain * d[c]
        if r.tilt >= 0:
            e, turning = axes[r.tilt], r.inertia * spin * w * slope[r.tilt]
            change[0] += turning * (e[1] * d[2] - e[2] * d[1])
            change[1] += turning * (e[2] * d[0] - e[0] * d[2])
            change[2] += turning * (e[0] * d[1] - e[1] * d[0])
    wrench[3] -= rate[1] * h[2] - rate[2] * h[1] + change[0]
    wrench[4] -= rate[2] * h[0] - rate[0] * h[2] + change[1]
    wrench[5] -= rate[0] * h[1] - rate[1] * h[0] + change[2]


@njit(cache=True, error_model="numpy")
def flapping(rotors, air, thrust, velocity, rate, position, direction, wrench):
    """Adds force and torque of rotor discs that tilt back against the air across them to `wrench` (6,).

    Force -c T v_perp in the rotor's plane, and the hub moment c T e (v_perp x d), e the stiffness over the thrust:
    first-order flapping, proportional to the advance ratio (Hoffmann, Huang, Waslander and Tomlin 2007, eq. 10 to 12).
    """
    c = air[0].flapping
    if c == 0.0:
        return
    e = air[0].hub_stiffness
    for i in range(rotors.shape[0]):
        p, d = position[i], direction[i]
        vx, vy, vz, along = rotor_air(velocity, rate, p, d)
        k = c * thrust[i]
        ax, ay, az = k * (vx - along * d[0]), k * (vy - along * d[1]), k * (vz - along * d[2])
        wrench[0] -= ax
        wrench[1] -= ay
        wrench[2] -= az
        wrench[3] += -(p[1] * az - p[2] * ay) + e * (ay * d[2] - az * d[1])
        wrench[4] += -(p[2] * ax - p[0] * az) + e * (az * d[0] - ax * d[2])
        wrench[5] += -(p[0] * ay - p[1] * ax) + e * (ax * d[1] - ay * d[0])


@njit(cache=True, error_model="numpy")
def rolling(rotors, air, square, velocity, rate, position, direction, wrench):
    """Adds the moment -k spin w v_perp of every rotor to `wrench` (6,): advancing blades lift more than retreating."""
    k = air[0].hub_moment
    if k == 0.0:
        return
    for i in range(rotors.shape[0]):
        p, d = position[i], direction[i]
        vx, vy, vz, along = rotor_air(velocity, rate, p, d)
        size = -k * rotors[i].spin * np.sqrt(square[i])
        wrench[3] += size * (vx - along * d[0])
        wrench[4] += size * (vy - along * d[1])
        wrench[5] += size * (vz - along * d[2])
