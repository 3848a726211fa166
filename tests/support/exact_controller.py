"""The exact simulation's path, which excites (it tilts, yaws, climbs and passes low), and the PD controller on it."""

from __future__ import annotations

from collections import namedtuple

import numpy as np
from exact_vectors import attitude, cross, dot, plus, product, times, transposed_times
from numba import njit

Control = namedtuple("Control", "tilting mixer gains_p gains_a arms k_f mass inertia gravity")
Path = namedtuple("Path", "center amplitude frequency phase turn turn_frequency turn_phase")


def control_of(vehicle, share_commands):
    """Gains and the inverse of the nominal mixer: from a wrench to thrusts (no tilts) or to arms' components."""
    files, joints = vehicle["rotors"], vehicle.get("tilts", [])
    k_f = np.array([r["thrust_coefficient"] for r in files])
    j = vehicle["inertia"]
    inertia = np.array([j["xx"], j["yy"], j["zz"]])
    if not joints:
        columns = []
        for r in files:
            d = np.array(r.get("axis", [0.0, 0.0, 1.0]), dtype=float)
            columns.append(np.concatenate([[d[2]], np.cross(r["position"], d) - r["spin"] * r["moment_constant"] * d]))
        mixer = np.linalg.pinv(np.array(columns).T)
        arms = np.zeros((0, len(files)))
        gains_a = np.array([[90.0, 90.0, 20.0], [18.0, 18.0, 7.0]])
    else:
        axes = []
        arms = np.array([[float(r.get("tilt") == i) for r in files] for i in range(len(joints))])
        for joint in joints:
            a = np.array(joint["axis"], dtype=float)
            a = a / np.linalg.norm(a)
            up, side = np.array([0.0, 0.0, 1.0]), np.cross(a, [0.0, 0.0, 1.0])
            axes.append((a, up, side))
        cells = []
        for which in (1, 2):
            for i, c in enumerate(axes):
                arm = max(abs(np.dot(c[0], r["position"])) for r in files if r.get("tilt") == i)
                cells.append(np.concatenate([c[which], np.cross(arm * c[0], c[which])]))
        mixer = np.linalg.pinv(np.array(cells).T)
        gains_a = np.array([[36.0, 36.0, 36.0], [11.0, 11.0, 11.0]])
    if not share_commands:
        raise NotImplementedError("rotors of one arm share a command here")
    return Control(
        bool(joints),
        np.ascontiguousarray(mixer),
        np.array([6.0, 4.0]),
        gains_a,
        np.ascontiguousarray(arms),
        k_f,
        vehicle["mass"],
        inertia,
        vehicle.get("gravity", 9.81),
    )


def path_of(vehicle, rng):
    """Sums of two sines for x, y, z and, where the vehicle can, three angles; low over the ground once in a while."""
    amplitude = np.array([[1.0, 0.25], [0.9, 0.3], [0.5, 0.12]])
    frequency = np.array([[1.4, 3.1], [1.1, 2.7], [1.7, 4.3]]) * rng.uniform(0.85, 1.15, (3, 2))
    phase = rng.uniform(-np.pi, np.pi, (3, 2))
    turn = np.array([[0.35, 0.1], [0.35, 0.1], [0.8, 0.2]])
    turn_frequency = np.array([[1.9, 4.1], [1.6, 3.7], [0.9, 2.3]]) * rng.uniform(0.85, 1.15, (3, 2))
    return Path(
        np.array([0.0, 0.0, 0.95]),
        amplitude,
        frequency,
        phase,
        turn,
        turn_frequency,
        rng.uniform(-np.pi, np.pi, (3, 2)),
    )


def calmer(path, motion):
    return path._replace(amplitude=motion * path.amplitude, turn=motion * path.turn)


@njit(cache=True)
def reference(time, path):
    """Position, velocity, acceleration and angles with their rates, rising smoothly from rest in the first second."""
    s, ds, dds = 1.0, 0.0, 0.0
    length = 1.5
    if time < length:
        x = time / length
        s = x**3 * (10 - 15 * x + 6 * x * x)
        ds = 30 * x**2 * (1 - x) ** 2 / length
        dds = 60 * x * (1 - 3 * x + 2 * x * x) / length**2
    out, angles = np.zeros((3, 3)), np.zeros((2, 3))
    for i in range(3):
        for k in range(2):
            a, f, p = path.amplitude[i, k], path.frequency[i, k], path.phase[i, k]
            y, dy, ddy = a * np.sin(f * time + p), a * f * np.cos(f * time + p), -a * f * f * np.sin(f * time + p)
            out[0, i] += s * y
            out[1, i] += s * dy + ds * y
            out[2, i] += s * ddy + 2 * ds * dy + dds * y
            a, f, p = path.turn[i, k], path.turn_frequency[i, k], path.turn_phase[i, k]
            angles[0, i] += s * a * np.sin(f * time + p)
            angles[1, i] += s * a * f * np.cos(f * time + p) + ds * a * np.sin(f * time + p)
        out[0, i] += path.center[i]
    return out, angles


@njit(cache=True)
def commands(time, state, n, m, control, path):
    """PD control with the reference's acceleration; rotor speeds and tilts."""
    out, angles = reference(time, path)
    r = attitude(state[3:7])
    w = state[10:13]
    acceleration = np.empty(3)
    for i in range(3):
        place, speed = out[0, i] - state[i], out[1, i] - state[7 + i]
        acceleration[i] = out[2, i] + control.gains_p[0] * place + control.gains_p[1] * speed
    acceleration[2] += control.gravity
    yaw = angles[0, 2]
    if control.tilting:
        roll, pitch = angles[0, 0], angles[0, 1]
        turn_z = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
        turn_y = np.array([[np.cos(pitch), 0.0, np.sin(pitch)], [0.0, 1.0, 0.0], [-np.sin(pitch), 0.0, np.cos(pitch)]])
        turn_x = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(roll), -np.sin(roll)], [0.0, np.sin(roll), np.cos(roll)]])
        goal = product(turn_z, product(turn_y, turn_x))
        goal_rate = np.array([angles[1, 0], angles[1, 1], angles[1, 2]])
    else:
        up = plus(np.zeros(3), 1.0 / np.sqrt(dot(acceleration, acceleration)), acceleration)
        ahead = np.array([np.cos(yaw), np.sin(yaw), 0.0])
        side = cross(up, ahead)
        side = plus(np.zeros(3), 1.0 / np.sqrt(dot(side, side)), side)
        front = cross(side, up)
        goal = np.empty((3, 3))
        for i in range(3):
            goal[i, 0], goal[i, 1], goal[i, 2] = front[i], side[i], up[i]
        goal_rate = np.array([0.0, 0.0, angles[1, 2]])
    wrench = np.empty(6)
    force = transposed_times(r, acceleration)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        error = 0.0
        for a in range(3):
            error += 0.5 * (goal[a, k] * r[a, j] - goal[a, j] * r[a, k])
        turning = -control.gains_a[0, i] * error - control.gains_a[1, i] * (w[i] - goal_rate[i])
        wrench[i], wrench[3 + i] = control.mass * force[i], control.inertia[i] * turning
    rotor, tilt = np.empty(n), np.empty(m)
    if control.tilting:
        parts = times(control.mixer, wrench)
        for i in range(m):
            # A positive tilt about the outward axis a turns the thrust z into a x z cos(90 deg)..., as sin a.
            tilt[i] = np.arctan2(parts[m + i], parts[i])
            size = np.sqrt(parts[i] ** 2 + parts[m + i] ** 2)
            members = np.sum(control.arms[i])
            for k in range(n):
                if control.arms[i, k] > 0:
                    rotor[k] = np.sqrt(size / members / control.k_f[k])
    else:
        thrust = times(control.mixer, wrench[2:6])
        for k in range(n):
            rotor[k] = np.sqrt(max(thrust[k], 0.02 * control.mass) / control.k_f[k])
    return rotor, tilt
