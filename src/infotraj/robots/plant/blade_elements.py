"""Rotors by blade-element momentum theory, for a plant that no effect of the catalogue matches exactly. Compiled.

Each blade is cut into elements, at several azimuths of a turn. An element at radius r moves through the air with u_t
along its path and u_p down through the disc; lift and drag follow from the angle between (Leishman, Principles of
Helicopter Aerodynamics, 2nd ed., 3.2 and 3.5). Their means over a turn are thrust, H-force (in the disc), torque and
the hub's rolling and pitching moments, of stiff blades. The mean induced velocity is the one at which momentum theory
in forward flight (Glauert; 2.14) has the blades' thrust, found at each step; over the disc it is linear (Drees; 3.5.2):
larger at the rear.
"""

from __future__ import annotations

import numpy as np
from numba import njit

RADII, AZIMUTHS = 8, 12  # elements of a blade and of a turn; twice as many change thrust and H-force by less than 0.1 %
_TURN = 2.0 * np.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
_COSINES, _SINES = np.cos(_TURN), np.sin(_TURN)  # from the rear to the advancing side
ROUNDS, CLOSE = 20, 1e-5  # of Newton's method; m/s


@njit(cache=True, error_model="numpy")
def loads(blade, radius, w, across, along, tilting, inflow, out):
    """Means over a turn of one rotor's loads, seen as counter-clockwise, into `out` (6,).

    Forces (N) to the rear, to the advancing side and up the axis, moments (N m) about these.

    blade: a row of BLADE; w rad/s; across, along (m/s): the hub's speed forward in its disc and up its axis; tilting
    (2,) rad/s: how fast the disc's rear and advancing edge rise; inflow (m/s): mean induced velocity, downward.
    """
    advance = across / max(w * radius, 1e-9)
    # Drees: the wake's skew, and how much more inflow the rear and less the advancing side has
    down = max(along + inflow, 1e-9)
    slant = np.sqrt(across**2 + down**2)
    lengthwise = 0.0
    if across > 1e-4 * slant:
        lengthwise = 4.0 / 3.0 * (1.0 - down / slant - 1.8 * advance**2) / (across / slant)
    # the linear form is for advance ratios of flight: it stays a share of the mean where a rotor hardly turns
    lengthwise, sideways = min(max(lengthwise, -1.5), 1.5), max(-2.0 * advance, -1.5)
    out[:] = 0.0
    width = (1.0 - blade.cutout) / RADII
    scale = 0.5 * blade.density * width * radius * blade.count / AZIMUTHS
    for i in range(RADII):
        x = blade.cutout + (i + 0.5) * width
        r = x * radius
        rise = blade.pitch / (2.0 * np.pi * r)
        flat = 1.0 / np.sqrt(1.0 + rise**2)
        rise *= flat
        area = scale * (blade.root_chord + (blade.tip_chord - blade.root_chord) * x)
        for j in range(AZIMUTHS):
            cosine, sine = _COSINES[j], _SINES[j]
            u_t = w * r + across * sine
            u_p = along + r * (tilting[0] * cosine + tilting[1] * sine)
            u_p += inflow * (1.0 + x * (lengthwise * cosine + sideways * sine))
            speed = np.sqrt(u_t**2 + u_p**2) + 1e-12
            c, s = u_t / speed, u_p / speed
            attack, straight = rise * c - flat * s, flat * c + rise * s  # sine and cosine of the angle of attack
            lift = area * speed**2 * blade.lift_slope * attack * straight
            drag = area * speed**2 * (blade.drag + blade.drag_rise * attack**2)
            up, back = lift * c - drag * s, -(lift * s + drag * c)
            out[0] -= back * sine
            out[1] += back * cosine
            out[2] += up
            out[3] += r * up * sine
            out[4] -= r * up * cosine
            out[5] += r * back


@njit(cache=True, error_model="numpy")
def balanced(blade, radius, w, across, along, tilting, start, out):
    """The same with the mean induced velocity (m/s) that momentum theory has for the blades' thrust, which it returns.

    T = 2 rho A v_i sqrt(across^2 + (along + v_i)^2), by Newton's method from `start` (m/s), best the last step's.
    """
    disc = 2.0 * blade.density * np.pi * radius**2
    beside = np.empty(6)
    inflow = start
    for _ in range(ROUNDS):
        step = 1e-3
        loads(blade, radius, w, across, along, tilting, inflow, out)
        loads(blade, radius, w, across, along, tilting, inflow + step, beside)
        here = disc * inflow * np.sqrt(across**2 + (along + inflow) ** 2) - out[2]
        there = disc * (inflow + step) * np.sqrt(across**2 + (along + inflow + step) ** 2) - beside[2]
        slope = (there - here) / step
        # in descent through its own wake momentum theory has no single answer: then the change is held small
        change = -here / slope if slope > 0.0 else -0.5 * np.sign(here)
        change = min(max(change, -3.0), 3.0)
        if abs(change) < CLOSE:
            break
        inflow = min(max(inflow + change, 0.0), 60.0)
    return inflow


@njit(cache=True, error_model="numpy")
def blades(rotors, blade, square, velocity, rate, position, direction, thrust, wrench):
    """Overwrites `thrust` (rotors,) and adds to `wrench` (6,) what comes with it beside thrust x moment constant.

    square (rotors,) speeds squared; velocity and rate (3,) of the body's origin through the air, body frame.
    """
    if blade[0].count == 0.0:
        return
    rear, tilting, out = np.empty(3), np.empty(2), np.empty(6)
    for i in range(rotors.shape[0]):
        p, d, r = position[i], direction[i], rotors[i]
        hx = velocity[0] + rate[1] * p[2] - rate[2] * p[1]
        hy = velocity[1] + rate[2] * p[0] - rate[0] * p[2]
        hz = velocity[2] + rate[0] * p[1] - rate[1] * p[0]
        along = hx * d[0] + hy * d[1] + hz * d[2]
        rear[0], rear[1], rear[2] = along * d[0] - hx, along * d[1] - hy, along * d[2] - hz
        across = np.sqrt(rear[0] ** 2 + rear[1] ** 2 + rear[2] ** 2)
        if across < 1e-9:
            # any direction in the disc: the loads do not depend on it
            k = 0 if abs(d[0]) < 0.8 else 1
            for c in range(3):
                rear[c] = (1.0 if c == k else 0.0) - d[k] * d[c]
            across = 0.0
        rear /= np.sqrt(rear[0] ** 2 + rear[1] ** 2 + rear[2] ** 2)
        # a rotor with a positive moment turns clockwise (`rotor_moments`): its mirror image has all loads' signs
        spin = -np.sign(r.moment)
        side = spin * np.cross(d, rear)
        for c in range(2):
            e = rear if c == 0 else side
            tilting[c] = (
                (rate[1] * e[2] - rate[2] * e[1]) * d[0]
                + (rate[2] * e[0] - rate[0] * e[2]) * d[1]
                + (rate[0] * e[1] - rate[1] * e[0]) * d[2]
            )
        if r.inflow == 0.0:
            hover = r.thrust_coefficient * square[i] / (2.0 * blade[0].density * np.pi * r.radius**2)
            rotors[i].inflow = np.sqrt(hover)
        w = np.sqrt(square[i])
        rotors[i].inflow = balanced(blade[0], r.radius, w, across, along, tilting, r.inflow, out)
        thrust[i] = max(out[2] * r.factor, 0.0)
        # MuJoCo's thruster brings the thrust and `moment` times it; the rest is applied here
        twist = spin * out[5] - r.moment * thrust[i]
        fx, fy, fz = out[0] * rear + out[1] * side
        wrench[0] += fx
        wrench[1] += fy
        wrench[2] += fz
        wrench[3] += p[1] * fz - p[2] * fy + spin * (out[3] * rear[0] + out[4] * side[0]) + twist * d[0]
        wrench[4] += p[2] * fx - p[0] * fz + spin * (out[3] * rear[1] + out[4] * side[1]) + twist * d[1]
        wrench[5] += p[0] * fy - p[1] * fx + spin * (out[3] * rear[2] + out[4] * side[2]) + twist * d[2]
