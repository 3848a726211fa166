"""An exact simulation of the catalogue, for time stamps and signs: shares no code with infotraj's effects and models.

Written from the specification of the catalogue and of the flight table alone. A rigid body about its origin (spatial
inertia, Featherstone 2008, 2.13), first-order rotors and rate-limited tilts, and every effect by name, integrated by
Runge-Kutta's fourth order in steps of at most `SUBSTEP`; steps end exactly where a command begins to act and where a
sensor is sampled. A PD controller flies a path that excites: it tilts, yaws, climbs and passes low over the ground.

    table = fly(vehicle_file_content, {"com_offset": {"r": [0.01, 0, 0]}}, seconds=16.0, seed=1)
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np
import pandas as pd
from numba import njit

SUBSTEP = 5e-4
ROW = 0.005

Body = namedtuple("Body", "mass inertia com gravity")
Rotors = namedtuple(
    "Rotors",
    "position axis spin k_f moment tilt radius lower factor reaction inflow ground drag inertia tau interference "
    "hover exponent lift hub",
)
Tilts = namedtuple("Tilts", "axis tau limit play bias order")
Air = namedtuple("Air", "linear quadratic damping force torque wind centre")
Other = namedtuple("Other", "sag_rate sag_exponent volts_rate load length delay sensor_lag")
Control = namedtuple("Control", "tilting mixer gains_p gains_a arms k_f mass inertia gravity")
Path = namedtuple("Path", "center amplitude frequency phase turn turn_frequency turn_phase")


def fly(
    vehicle,
    effects,
    *,
    seconds=8.0,
    seed=0,
    noise=None,
    row=ROW,
    substep=SUBSTEP,
    share_commands=True,
    start=0.0,
    motion=1.0,
):
    """A flight table (pandas) of the vehicle with hidden `effects` {name: {parameter: value}} (or a list of pairs).

    noise: None, or standard deviations {"gyro", "accelerometer", "position", "attitude", "velocity"} a sample;
    motion: times the usual path.
    """
    pairs = list(effects.items()) if isinstance(effects, dict) else list(effects)
    by_name = {name: dict(values) for name, values in pairs}
    body, rotors, tilts, air, other = _truth(vehicle, pairs)
    rng = np.random.default_rng(seed)
    rows = np.arange(round(seconds / row) + 1) * row
    imu_shift = by_name.get("time_offset", {}).get("dt", 0.0)
    out = _simulate(
        rows,
        rows - imu_shift,
        substep,
        body,
        rotors,
        tilts,
        air,
        other,
        _control(vehicle, share_commands),
        _calmer(_path(vehicle, rng), motion),
    )
    state, imu, cmd_rotor, cmd_tilt, rotor, tilt = out
    turn = _rotation(np.array(by_name.get("imu_misalignment", {}).get("rotvec", np.zeros(3)), dtype=float))
    bias = np.array(by_name.get("gyro_bias", {}).get("b", np.zeros(3)), dtype=float)
    columns = {"t": rows + start}
    _put(columns, ["px", "py", "pz"], state[:, 0:3])
    _put(columns, ["qw", "qx", "qy", "qz"], state[:, 3:7])
    _put(columns, ["vx", "vy", "vz"], state[:, 7:10])
    _put(columns, ["wx", "wy", "wz"], imu[:, 0:3] @ turn.T + bias)
    _put(columns, ["ax", "ay", "az"], imu[:, 3:6] @ turn.T)
    _put(columns, [f"cmd_rotor_{i}" for i in range(cmd_rotor.shape[1])], cmd_rotor)
    _put(columns, [f"cmd_tilt_{i}" for i in range(cmd_tilt.shape[1])], cmd_tilt)
    _put(columns, [f"rotor_{i}" for i in range(cmd_rotor.shape[1])], rotor)
    _put(columns, [f"tilt_{i}" for i in range(cmd_tilt.shape[1])], tilt)
    if other.sag_exponent != 0.0:
        columns["battery"] = vehicle["nominal_voltage"] * (1.0 - other.volts_rate * rows)
    table = pd.DataFrame(columns)
    return table if noise is None else _noisy(table, noise, rng)


def _put(columns, names, values):
    for i, name in enumerate(names):
        columns[name] = values[:, i]


def _noisy(table, noise, rng):
    n = len(table)
    for names, key in (
        (["wx", "wy", "wz"], "gyro"),
        (["ax", "ay", "az"], "accelerometer"),
        (["px", "py", "pz"], "position"),
        (["vx", "vy", "vz"], "velocity"),
    ):
        table[names] += noise.get(key, 0.0) * rng.standard_normal((n, 3))
    q = table[["qw", "qx", "qy", "qz"]].to_numpy()
    e = 0.5 * noise.get("attitude", 0.0) * rng.standard_normal((n, 3))
    w, x, y, z = q.T
    step = np.stack([-x, -y, -z], 1), np.stack([w, -z, y], 1), np.stack([z, w, -x], 1), np.stack([-y, x, w], 1)
    q = q + np.stack([np.sum(s * e, axis=1) for s in step], axis=1)
    table[["qw", "qx", "qy", "qz"]] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return table


def _rotation(v):
    angle = np.linalg.norm(v)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if angle == 0.0:
        return np.eye(3)
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * (k @ k)


def _truth(vehicle, pairs):
    """What is simulated: the vehicle file's numbers, changed by the effects as the catalogue defines them."""
    listed = [(name, values) for name, values in pairs]
    one = dict(listed)

    def value(name, parameter, absent=0.0):
        return one.get(name, {}).get(parameter, absent)

    def vector(name, parameter, size=3):
        return np.array(value(name, parameter, np.zeros(size)), dtype=float) * np.ones(size)

    j = vehicle["inertia"]
    inertia = np.array(
        [
            [j["xx"] + value("inertia_error", "dxx"), j.get("xy", 0.0), j.get("xz", 0.0)],
            [j.get("xy", 0.0), j["yy"] + value("inertia_error", "dyy"), j.get("yz", 0.0)],
            [j.get("xz", 0.0), j.get("yz", 0.0), j["zz"] + value("inertia_error", "dzz")],
        ]
    )
    com = np.array(vehicle.get("center_of_mass", [0.0, 0.0, 0.0])) + vector("com_offset", "r")
    body = Body(vehicle["mass"] + value("mass_offset", "dm"), inertia, com, vehicle.get("gravity", 9.81))

    files, joints = vehicle["rotors"], vehicle.get("tilts", [])
    n, m = len(files), len(joints)
    factor = np.full(n, float(value("thrust_scale", "factor", 1.0)))
    for name, values in listed:
        if name == "rotor_effectiveness":
            factor[values["rotor"]] *= values["factor"]
    lower = np.array([r.get("coaxial") == "lower" for r in files])
    factor[lower] *= 1.0 - value("coaxial_loss", "fraction")
    rotors = Rotors(
        np.array([r["position"] for r in files], dtype=float),
        np.array([r.get("axis", [0, 0, 1]) for r in files], dtype=float),
        np.array([r["spin"] for r in files], dtype=float),
        np.array([r["thrust_coefficient"] for r in files]),
        np.array([r["moment_constant"] for r in files]),
        np.array([-1 if r.get("tilt") is None else r["tilt"] for r in files]),
        np.array([r.get("radius", 0.0) for r in files]),
        lower,
        factor,
        float(value("moment_scale", "factor", 1.0)),
        float(value("axial_inflow", "k")),
        float(value("ground_effect", "k")),
        float(value("rotor_drag", "k")),
        float(value("gyroscopic", "rotor_inertia")),
        np.array([r.get("time_constant", 0.0) for r in files]) + value("rotor_lag", "extra_time_constant"),
        float(value("rotor_interference", "k")),
        np.sqrt(
            vehicle["mass"] * vehicle.get("gravity", 9.81) / n / np.array([r["thrust_coefficient"] for r in files])
        ),
        float(value("thrust_exponent", "n", 2.0)),
        float(value("translational_lift", "k")),
        float(value("hub_moment", "k")),
    )
    axes = np.array([a["axis"] for a in joints], dtype=float).reshape(m, 3)
    axes = axes / np.linalg.norm(axes, axis=1, keepdims=True) if m else axes
    declared = np.array([a.get("max_rate", np.inf) for a in joints], dtype=float).reshape(m)
    tilts = Tilts(
        axes,
        np.array([a.get("time_constant", 0.0) for a in joints], dtype=float).reshape(m)
        + value("servo_lag", "extra_time_constant"),
        np.minimum(declared, value("servo_rate_limit", "max_rate", np.inf)),
        float(value("servo_backlash", "half_width")),
        np.array(value("servo_bias", "bias", np.zeros(m)), dtype=float).reshape(m) if m else np.zeros(0),
        np.argsort(np.arctan2(axes[:, 1], axes[:, 0])) if m else np.zeros(0, dtype=np.int64),
    )
    air = Air(
        vector("linear_drag", "d"),
        vector("quadratic_drag", "d"),
        vector("angular_damping", "d"),
        vector("steady_force", "f"),
        vector("steady_torque", "t"),
        vector("wind", "v"),
        vector("pressure_centre", "r"),
    )
    other = Other(
        float(value("battery_sag", "rate")),
        float(value("battery_sag", "exponent")),
        0.006,
        float(value("suspended_load", "mass")),
        float(value("suspended_load", "length", 1.0)),
        float(value("actuation_delay", "delay")),
        float(value("sensor_lag", "time_constant")),
    )
    return body, rotors, tilts, air, other


def _control(vehicle, share_commands):
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
        columns = []
        arms = np.array([[float(r.get("tilt") == i) for r in files] for i in range(len(joints))])
        for joint in joints:
            a = np.array(joint["axis"], dtype=float)
            a = a / np.linalg.norm(a)
            up, side = np.array([0.0, 0.0, 1.0]), np.cross(a, [0.0, 0.0, 1.0])
            columns.append((a, up, side))
        cells = []
        for which in (1, 2):
            for i, c in enumerate(columns):
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


def _path(vehicle, rng):
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


def _calmer(path, motion):
    return path._replace(amplitude=motion * path.amplitude, turn=motion * path.turn)


# Small helpers instead of array expressions: numba compiles every expression anew, and a test run waits for it.


@njit(cache=True)
def _cross(a, b):
    out = np.empty(3)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


@njit(cache=True)
def _dot(a, b):
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@njit(cache=True)
def _sum(a, scale, b):
    """a + scale b"""
    out = np.empty(len(a))
    for i in range(len(a)):
        out[i] = a[i] + scale * b[i]
    return out


@njit(cache=True)
def _times(matrix, x):
    out = np.zeros(matrix.shape[0])
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            out[i] += matrix[i, j] * x[j]
    return out


@njit(cache=True)
def _back(matrix, x):
    """The transpose of a matrix times x."""
    out = np.zeros(matrix.shape[1])
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            out[j] += matrix[i, j] * x[i]
    return out


@njit(cache=True)
def _product(a, b):
    out = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                out[i, j] += a[i, k] * b[k, j]
    return out


@njit(cache=True)
def _solve(system, right):
    """Gauss' elimination with row exchanges."""
    a, x, n = system.copy(), right.copy(), len(right)
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        for j in range(n):
            a[k, j], a[best, j] = a[best, j], a[k, j]
        x[k], x[best] = x[best], x[k]
        for i in range(k + 1, n):
            share = a[i, k] / a[k, k]
            for j in range(k, n):
                a[i, j] -= share * a[k, j]
            x[i] -= share * x[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            x[k] -= a[k, j] * x[j]
        x[k] /= a[k, k]
    return x


@njit(cache=True)
def _turned(v, axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    across, along = _cross(axis, v), _dot(axis, v) * (1.0 - c)
    out = np.empty(3)
    for i in range(3):
        out[i] = v[i] * c + across[i] * s + axis[i] * along
    return out


@njit(cache=True)
def _attitude(q):
    w, x, y, z = q[0], q[1], q[2], q[3]
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


@njit(cache=True)
def _lagged(target, x, tau, limit):
    """Rate of a first-order lag with a greatest rate; an actuator without a lag does not come here."""
    rate = (target - x) / tau
    return min(max(rate, -limit), limit)


@njit(cache=True)
def _derivative(state, n, m, time, rotor_cmd, tilt_cmd, arm_held, body, rotors, tilts, air, other):
    """Time derivative of the state, and specific force and rate in body axes.

    State: position, quaternion, velocity (world), rate, n rotor speeds, m servo angles, load direction and its rate,
    what the sensors' filters hold of rate and specific force.
    """
    d_state = np.zeros(len(state))
    r = _attitude(state[3:7])
    # Through the air: nothing here asks for the velocity over the ground.
    v, w = _back(r, _sum(state[7:10], -1.0, air.wind)), state[10:13]
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
            p, d = _turned(p, tilts.axis[j], tilt[j]), _turned(d, tilts.axis[j], tilt[j])
        air_speed = _sum(v, 1.0, _cross(w, p))
        thrust = rotors.k_f[i] * rotors.hover[i] ** (2.0 - rotors.exponent) * speed[i] ** rotors.exponent
        thrust *= rotors.factor[i] * sag
        if rotors.ground != 0.0:
            height = state[2] + r[2, 0] * p[0] + r[2, 1] * p[1] + r[2, 2] * p[2]
            thrust *= 1.0 + rotors.ground * (rotors.radius[i] / height) ** 2
        if j >= 0:
            thrust *= 1.0 - loss[j]
        axial = _dot(air_speed, d)
        thrust -= rotors.inflow * speed[i] * axial
        across = _sum(air_speed, -axial, d)
        thrust += rotors.lift * _dot(across, across)
        torque = _sum(torque, -rotors.spin[i] * rotors.hub * speed[i], across)
        here = _sum(np.zeros(3), thrust, d)
        here = _sum(here, -rotors.drag * speed[i], across)
        force = _sum(force, 1.0, here)
        torque = _sum(torque, 1.0, _cross(p, here))
        torque = _sum(torque, -rotors.spin[i] * rotors.moment[i] * rotors.reaction * thrust, d)
        carried = rotors.inertia * rotors.spin[i]
        momentum = _sum(momentum, carried * speed[i], d)
        momentum_rate = _sum(momentum_rate, carried * speed_rate[i], d)
        if j >= 0:
            momentum_rate = _sum(momentum_rate, carried * speed[i] * tilt_rate[j], _cross(tilts.axis[j], d))
    steady, gyration, drag = _back(r, air.force), _cross(w, momentum), np.empty(3)
    for i in range(3):
        drag[i] = -air.linear[i] * v[i] - air.quadratic[i] * abs(v[i]) * v[i]
    turned = _cross(air.centre, drag)
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
            about_origin[i, j] = body.inertia[i, j] + mass * ((i == j) * _dot(c, c) - c[i] * c[j])
            system[i, 3 + j], system[3 + i, j] = -mass * shift[i, j], mass * shift[i, j]
            system[3 + i, 3 + j] = about_origin[i, j]
    pull, gyration = _cross(w, _cross(w, c)), _cross(w, _times(about_origin, w))
    for i in range(3):
        right[i], right[3 + i] = force[i] - mass * pull[i], torque[i] - gyration[i]
    u, u_rate = state[13 + n + m : 16 + n + m], state[16 + n + m : 19 + n + m]
    along = _back(r, u)
    for i in range(3):
        system[i, 6], system[6, i] = -along[i], other.load * along[i]
    system[6, 6] = 1.0
    right[6] = other.load * other.length * _dot(u_rate, u_rate)
    solved = _solve(system, right)
    f = solved[0:3].copy()
    f_world = _times(r, f)
    q = state[3:7]
    d_state[3] = 0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2])
    d_state[4] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1])
    d_state[5] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2])
    d_state[6] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0])
    swing, push_along = _dot(u_rate, u_rate), _dot(f_world, u)
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


@njit(cache=True)
def _reference(time, path):
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
def _commands(time, state, n, m, control, path):
    """PD control with the reference's acceleration; rotor speeds and tilts."""
    out, angles = _reference(time, path)
    r = _attitude(state[3:7])
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
        goal = _product(turn_z, _product(turn_y, turn_x))
        goal_rate = np.array([angles[1, 0], angles[1, 1], angles[1, 2]])
    else:
        up = _sum(np.zeros(3), 1.0 / np.sqrt(_dot(acceleration, acceleration)), acceleration)
        ahead = np.array([np.cos(yaw), np.sin(yaw), 0.0])
        side = _cross(up, ahead)
        side = _sum(np.zeros(3), 1.0 / np.sqrt(_dot(side, side)), side)
        front = _cross(side, up)
        goal = np.empty((3, 3))
        for i in range(3):
            goal[i, 0], goal[i, 1], goal[i, 2] = front[i], side[i], up[i]
        goal_rate = np.array([0.0, 0.0, angles[1, 2]])
    wrench = np.empty(6)
    force = _back(r, acceleration)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        error = 0.0
        for a in range(3):
            error += 0.5 * (goal[a, k] * r[a, j] - goal[a, j] * r[a, k])
        turning = -control.gains_a[0, i] * error - control.gains_a[1, i] * (w[i] - goal_rate[i])
        wrench[i], wrench[3 + i] = control.mass * force[i], control.inertia[i] * turning
    rotor, tilt = np.empty(n), np.empty(m)
    if control.tilting:
        parts = _times(control.mixer, wrench)
        for i in range(m):
            # A positive tilt about the outward axis a turns the thrust z into a x z cos(90 deg)..., as sin a.
            tilt[i] = np.arctan2(parts[m + i], parts[i])
            size = np.sqrt(parts[i] ** 2 + parts[m + i] ** 2)
            members = np.sum(control.arms[i])
            for k in range(n):
                if control.arms[i, k] > 0:
                    rotor[k] = np.sqrt(size / members / control.k_f[k])
    else:
        thrust = _times(control.mixer, wrench[2:6])
        for k in range(n):
            rotor[k] = np.sqrt(max(thrust[k], 0.02 * control.mass) / control.k_f[k])
    return rotor, tilt


@njit(cache=True)
def _jump(state, n, m, rotor_cmd, tilt_cmd, rotors, tilts):
    """Actuators without a lag are at their command at once."""
    for i in range(n):
        if rotors.tau[i] <= 0:
            state[13 + i] = rotor_cmd[i]
    for i in range(m):
        if tilts.tau[i] <= 0:
            state[13 + n + i] = tilt_cmd[i]


@njit(cache=True)
def _advance(state, arm, start, stop, substep, n, m, rotor_cmd, tilt_cmd, body, rotors, tilts, air, other):
    steps = max(1, int(np.ceil((stop - start) / substep - 1e-9)))
    h = (stop - start) / steps
    for k in range(steps):
        t = start + k * h
        k1, _ = _derivative(state, n, m, t, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        at = _sum(state, 0.5 * h, k1)
        k2, _ = _derivative(at, n, m, t + 0.5 * h, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        at = _sum(state, 0.5 * h, k2)
        k3, _ = _derivative(at, n, m, t + 0.5 * h, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        at = _sum(state, h, k3)
        k4, _ = _derivative(at, n, m, t + h, rotor_cmd, tilt_cmd, arm, body, rotors, tilts, air, other)
        for i in range(len(state)):
            state[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
        for unit in (state[3:7], state[13 + n + m : 16 + n + m]):
            size = np.sqrt(_dot(unit, unit))
            for i in range(len(unit)):
                unit[i] /= size
        for i in range(m):
            x = state[13 + n + i]
            arm[i] = min(max(arm[i], x - tilts.play), x + tilts.play)


@njit(cache=True)
def _simulate(rows, samples, substep, body, rotors, tilts, air, other, control, path):
    """States at `rows`, rate and specific force at `samples`, commands of the rows, actuators at the rows."""
    count, n, m = len(rows), len(rotors.spin), len(tilts.tau)
    states, imu = np.empty((count, 10)), np.empty((count, 6))
    cmd_rotor, cmd_tilt = np.empty((count, n)), np.empty((count, m))
    out_rotor, out_tilt = np.empty((count, n)), np.empty((count, m))
    state = np.zeros(25 + n + m)
    start, _ = _reference(rows[0], path)
    state[0:3] = start[0]
    state[3] = 1.0
    state[15 + n + m] = -1.0
    rotor, tilt = _commands(rows[0], state, n, m, control, path)
    state[13 : 13 + n], state[13 + n : 13 + n + m] = rotor, tilt
    arm = tilt.copy()
    now_rotor, now_tilt = rotor.copy(), tilt.copy()
    waiting_rotor, waiting_tilt = np.empty((count, n)), np.empty((count, m))
    time, row, sample, event = rows[0], 0, 0, 0
    _, f = _derivative(state, n, m, 0.0, now_rotor, now_tilt, arm, body, rotors, tilts, air, other)
    state[19 + n + m : 22 + n + m], state[22 + n + m : 25 + n + m] = state[10:13], f
    while sample < count and samples[sample] < rows[0]:
        imu[sample, 0:3], imu[sample, 3:6] = state[10:13], f
        sample += 1
    last = max(rows[count - 1], samples[count - 1])
    while True:
        # At one instant: the IMU first, then the row (pose, new command), then a command that begins to act.
        if sample < count and samples[sample] <= time + 1e-12:
            _, f = _derivative(state, n, m, time - rows[0], now_rotor, now_tilt, arm, body, rotors, tilts, air, other)
            imu[sample, 0:3], imu[sample, 3:6] = state[10:13], f
            if other.sensor_lag > 0.0:
                imu[sample] = state[19 + n + m : 25 + n + m]
            sample += 1
        if row < count and rows[row] <= time + 1e-12:
            states[row] = state[0:10]
            out_rotor[row] = state[13 : 13 + n]
            for i in range(m):
                out_tilt[row, i] = arm[i] + tilts.bias[i]
            rotor, tilt = _commands(time, state, n, m, control, path)
            cmd_rotor[row], cmd_tilt[row] = rotor, tilt
            waiting_rotor[row], waiting_tilt[row] = rotor, tilt
            row += 1
        if event < row and rows[event] + other.delay <= time + 1e-12:
            now_rotor, now_tilt = waiting_rotor[event].copy(), waiting_tilt[event].copy()
            _jump(state, n, m, now_rotor, now_tilt, rotors, tilts)
            event += 1
        if time >= last - 1e-12 or (row == count and sample == count):
            break
        upcoming = last
        if row < count:
            upcoming = min(upcoming, rows[row])
        if sample < count:
            upcoming = min(upcoming, samples[sample])
        if event < row:
            upcoming = min(upcoming, rows[event] + other.delay)
        _advance(
            state,
            arm,
            time - rows[0],
            upcoming - rows[0],
            substep,
            n,
            m,
            now_rotor,
            now_tilt,
            body,
            rotors,
            tilts,
            air,
            other,
        )
        time = upcoming
    return states, imu, cmd_rotor, cmd_tilt, out_rotor, out_tilt
