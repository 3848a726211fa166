"""The physics of the exact simulation: what the state's rates are, with every effect of the catalogue.

A rigid body about its origin (spatial inertia, Featherstone 2008, 2.13), first-order rotors and rate-limited tilts.
"""

from __future__ import annotations

import numpy as np
from exact_vectors import attitude, cross, dot, plus, solve, times, transposed_times, turned_about
from numba import njit


@njit(cache=True)
def _lagged(target, x, tau, limit):
    """Rate of a first-order lag with a greatest rate; an actuator without a lag does not come here."""
    rate = (target - x) / tau
    return min(max(rate, -limit), limit)


@njit(cache=True)
def derivative(state, n, m, time, rotor_cmd, tilt_cmd, arm_held, body, rotors, tilts, air, other):
    """Time derivative of the state, and specific force and rate in body axes.

    State: position, quaternion, velocity (world), rate, n rotor speeds, m servo angles, load direction and its rate,
    what the sensors' filters hold of rate and specific force.
    """
    d_state = np.zeros(len(state))
    r = attitude(state[3:7])
    # Through the air: nothing here asks for the velocity over the ground.
    v, w = transposed_times(r, plus(state[7:10], -1.0, air.wind)), state[10:13]
    speed, servo = state[13 : 13 + n], state[13 + n : 13 + n + m]
    tilt, tilt_rate = np.empty(m), np.zeros(m)
    for i in range(m):
        rate = _lagged(tilt_cmd[i], servo[i], tilts.tau[i], tilts.limit[i]) if tilts.tau[i] > 0 else 0.0
        d_state[13 + n + i] = rate
        arm = min(max(arm_held[i], servo[i] - tilts.play), servo[i] + tilts.play)
        tilt[i] = arm + tilts.bias[i]
        tilt_rate[i] = rate if (tilts.play == 0.0 or arm != arm_held[i]) else 0.0
    speed_rate = np.zeros(n)
    for i in range(n):
        if rotors.tau[i] > 0:
            speed_rate[i] = (rotor_cmd[i] - speed[i]) / rotors.tau[i]
        d_state[13 + i] = speed_rate[i]

    sag = 1.0 - other.sag_rate * time
    if other.sag_exponent != 0.0:
        sag *= (1.0 - other.volts_rate * time) ** other.sag_exponent
    push = np.zeros(m)
    for i in range(n):
        if rotors.tilt[i] >= 0:
            push[rotors.tilt[i]] += rotors.k_f[i] * speed[i] ** 2
    loss = np.zeros(m)
    if m > 0 and rotors.interference != 0.0:
        for place in range(m):
            before, after = tilts.order[(place - 1) % m], tilts.order[(place + 1) % m]
            ahead, back = max(0.0, np.sin(tilt[before])), max(0.0, -np.sin(tilt[after]))
            loss[tilts.order[place]] = (
                rotors.interference * (ahead**2 * push[before] + back**2 * push[after]) / (np.sum(push) / m)
            )

    force, torque = np.zeros(3), np.zeros(3)
    momentum, momentum_rate = np.zeros(3), np.zeros(3)
    for i in range(n):
        p, d = rotors.position[i].copy(), rotors.axis[i].copy()
        j = rotors.tilt[i]
        if j >= 0:
            p, d = turned_about(p, tilts.axis[j], tilt[j]), turned_about(d, tilts.axis[j], tilt[j])
        air_speed = plus(v, 1.0, cross(w, p))
        thrust = rotors.k_f[i] * rotors.hover[i] ** (2.0 - rotors.exponent) * speed[i] ** rotors.exponent
        thrust *= rotors.factor[i] * sag
        if rotors.ground != 0.0:
            height = state[2] + r[2, 0] * p[0] + r[2, 1] * p[1] + r[2, 2] * p[2]
            thrust *= 1.0 + rotors.ground * (rotors.radius[i] / height) ** 2
        if j >= 0:
            thrust *= 1.0 - loss[j]
        axial = dot(air_speed, d)
        thrust -= rotors.inflow * speed[i] * axial
        across = plus(air_speed, -axial, d)
        thrust += rotors.lift * dot(across, across)
        torque = plus(torque, -rotors.spin[i] * rotors.hub * speed[i], across)
        here = plus(np.zeros(3), thrust, d)
        here = plus(here, -rotors.drag * speed[i], across)
        force = plus(force, 1.0, here)
        torque = plus(torque, 1.0, cross(p, here))
        torque = plus(torque, -rotors.spin[i] * rotors.moment[i] * rotors.reaction * thrust, d)
        carried = rotors.inertia * rotors.spin[i]
        momentum = plus(momentum, carried * speed[i], d)
        momentum_rate = plus(momentum_rate, carried * speed_rate[i], d)
        if j >= 0:
            momentum_rate = plus(momentum_rate, carried * speed[i] * tilt_rate[j], cross(tilts.axis[j], d))
    steady, gyration, drag = transposed_times(r, air.force), cross(w, momentum), np.empty(3)
    for i in range(3):
        drag[i] = -air.linear[i] * v[i] - air.quadratic[i] * abs(v[i]) * v[i]
    turned = cross(air.centre, drag)
    for i in range(3):
        force[i] += steady[i] + drag[i]
        torque[i] += air.torque[i] + turned[i] - air.damping[i] * w[i] - gyration[i] - momentum_rate[i]

    # Newton and Euler at the origin: unknown specific force f, angular acceleration and tension of the cable.
    c, mass = body.com, body.mass
    shift = np.array([[0.0, -c[2], c[1]], [c[2], 0.0, -c[0]], [-c[1], c[0], 0.0]])
    about_origin = np.empty((3, 3))
    system, right = np.zeros((7, 7)), np.zeros(7)
    for i in range(3):
        system[i, i] = mass
        for j in range(3):
            about_origin[i, j] = body.inertia[i, j] + mass * ((i == j) * dot(c, c) - c[i] * c[j])
            system[i, 3 + j], system[3 + i, j] = -mass * shift[i, j], mass * shift[i, j]
            system[3 + i, 3 + j] = about_origin[i, j]
    pull, gyration = cross(w, cross(w, c)), cross(w, times(about_origin, w))
    for i in range(3):
        right[i], right[3 + i] = force[i] - mass * pull[i], torque[i] - gyration[i]
    u, u_rate = state[13 + n + m : 16 + n + m], state[16 + n + m : 19 + n + m]
    along = transposed_times(r, u)
    for i in range(3):
        system[i, 6], system[6, i] = -along[i], other.load * along[i]
    system[6, 6] = 1.0
    right[6] = other.load * other.length * dot(u_rate, u_rate)
    solved = solve(system, right)
    f = solved[0:3].copy()
    f_world = times(r, f)
    q = state[3:7]
    d_state[3] = 0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2])
    d_state[4] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1])
    d_state[5] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2])
    d_state[6] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0])
    swing, push_along = dot(u_rate, u_rate), dot(f_world, u)
    for i in range(3):
        d_state[i] = state[7 + i]
        d_state[7 + i] = f_world[i] - (body.gravity if i == 2 else 0.0)
        d_state[10 + i] = solved[3 + i]
        d_state[13 + n + m + i] = u_rate[i]
        d_state[16 + n + m + i] = -swing * u[i] - (f_world[i] - push_along * u[i]) / other.length
        if other.sensor_lag > 0.0:
            d_state[19 + n + m + i] = (w[i] - state[19 + n + m + i]) / other.sensor_lag
            d_state[22 + n + m + i] = (f[i] - state[22 + n + m + i]) / other.sensor_lag
    return d_state, f
