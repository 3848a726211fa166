"""Flies random smooth references with hidden effects, fast: a compiled rigid body that shares no code with infotraj.

The loop runs at 1 kHz (midpoint rule, actuators exactly); rows are written at 200 Hz. Each sensor in row k is sampled
at t[k], the command of row k acts from t[k] to t[k+1]. Effects are those of the catalogue by name; see `HIDDEN`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from numba import njit

RATE, SUBSTEPS = 200.0, 5
HIDDEN = (
    "linear_drag",
    "ground_effect",
    "battery_sag",
    "rotor_interference",
    "servo_lag",
    "thrust_scale",
    "delay_rows",
)
NOISE = {"position": 1e-3, "attitude": np.radians(0.1), "velocity": 5e-3, "rate": 0.01, "force": 0.1}


def fly(vehicle_path, seconds, seed, hidden=None, *, noise=1.0, low=1.0, turn=True):
    """A flight table (DataFrame). hidden: {name: value}; noise: times NOISE; low: least height (m)."""
    hidden = hidden or {}
    unknown = set(hidden) - set(HIDDEN)
    if unknown:
        raise KeyError(f"unknown effects {unknown}")
    content = yaml.safe_load(Path(vehicle_path).read_text())
    rng = np.random.default_rng(seed)
    body = _body(content)
    n = round(seconds * RATE) + 1
    t = np.arange(n) / RATE
    tilting = len(body["tau_tilt"]) > 0
    reference = _reference(t, rng, low, tilting and turn)
    effects = np.array([float(hidden.get(name, 0.0)) for name in HIDDEN])
    effects[HIDDEN.index("thrust_scale")] = float(hidden.get("thrust_scale", 1.0))
    state, sensed, commands = _loop(  # type: ignore[call-arg]  # numba has it as a function of one argument
        t, *reference, body["mass"], body["inertia"], body["gravity"], body["position"], body["axis"], body["k_f"],
        body["kappa"], body["tau_rotor"], body["tilt_of"], body["tilt_axis"], body["tau_tilt"], body["rate_tilt"],
        body["lower"], body["radius"], body["azimuth_order"], body["inverse"], effects, rng.standard_normal((n, 9)),
    )  # fmt: skip
    return _table(t, state, sensed, commands, len(body["k_f"]), len(body["tau_tilt"]), rng, noise)


def _body(content):
    rotors, tilts = content["rotors"], content.get("tilts", [])
    unit = [np.array(r.get("axis", [0, 0, 1]), float) for r in rotors]
    axis = np.array([a / np.linalg.norm(a) for a in unit])
    position = np.array([r["position"] for r in rotors], float)
    kappa = np.array([r["spin"] * r["moment_constant"] for r in rotors], float)
    tilt_of = np.array([-1 if r.get("tilt") is None else r["tilt"] for r in rotors])
    tilt_axis = np.array([j["axis"] for j in tilts], float).reshape(-1, 3)
    tilt_axis /= np.maximum(np.linalg.norm(tilt_axis, axis=1, keepdims=True), 1e-12)
    columns = []
    for quarter in (False, True):
        for k in range(len(rotors)):
            d, p = axis[k], position[k]
            if quarter:
                if tilt_of[k] < 0:
                    columns.append(np.zeros(6))
                    continue
                a = tilt_axis[tilt_of[k]]
                d, p = np.cross(a, d), np.dot(a, p) * a + np.cross(a, p)
            columns.append(np.concatenate([d, np.cross(p, d) - kappa[k] * d]))
    i = content["inertia"]
    return {
        "mass": float(content["mass"]),
        "gravity": float(content.get("gravity", 9.81)),
        "inertia": np.diag([i["xx"], i["yy"], i["zz"]]).astype(float),
        "position": position,
        "axis": axis,
        "k_f": np.array([r["thrust_coefficient"] for r in rotors], float),
        "kappa": kappa,
        "tau_rotor": np.array([r.get("time_constant", 0.0) for r in rotors], float),
        "tilt_of": tilt_of,
        "tilt_axis": tilt_axis,
        "tau_tilt": np.array([j.get("time_constant", 0.0) for j in tilts], float),
        "rate_tilt": np.array([j.get("max_rate", 1e9) for j in tilts], float),
        "lower": np.array([r.get("coaxial") == "lower" for r in rotors]),
        "radius": np.array([r.get("radius", 0.1) for r in rotors], float),
        "azimuth_order": np.argsort(np.arctan2(tilt_axis[:, 1], tilt_axis[:, 0])) if len(tilts) else np.zeros(0, int),
        "inverse": np.linalg.pinv(np.array(columns).T),
    }


def _waves(t, rng, size, slowest, fastest, terms=3):
    """A smooth random signal and its first two derivatives, (3, n); within about +-size."""
    f = rng.uniform(slowest, fastest, terms)
    a = size * rng.dirichlet(np.ones(terms)) * rng.uniform(0.7, 1.3)
    phase = rng.uniform(0, 2 * np.pi, terms)
    w = 2 * np.pi * f[:, None]
    angle = w * t + phase[:, None]
    return np.array([(a[:, None] * g).sum(0) for g in (np.sin(angle), w * np.cos(angle), -w * w * np.sin(angle))])


def _reference(t, rng, low, turning):
    """Position, velocity, acceleration (n, 3) and roll, pitch, yaw with their rates (n, 3)."""
    p = np.array([_waves(t, rng, 1.5, 0.08, 0.35), _waves(t, rng, 1.5, 0.08, 0.35), _waves(t, rng, 0.6, 0.05, 0.3)])
    p[2, 0] += low - p[2, 0].min()
    size = np.radians([28.0, 28.0, 35.0]) if turning else np.array([0.0, 0.0, np.radians(35.0)])
    angle = np.array([_waves(t, rng, s, 0.05, 0.3) for s in size])
    return (
        *(np.ascontiguousarray(p[:, k].T) for k in range(3)),
        *(np.ascontiguousarray(angle[:, k].T) for k in range(2)),
    )


def _table(t, state, sensed, commands, rotors, tilts, rng, noise):
    n = len(t)
    columns = {"t": t}
    p, v, q, w = state[:, :3], state[:, 3:6], state[:, 6:10], state[:, 10:13]
    p = p + noise * NOISE["position"] * rng.standard_normal((n, 3))
    v = v + noise * NOISE["velocity"] * rng.standard_normal((n, 3))
    w = w + noise * NOISE["rate"] * rng.standard_normal((n, 3))
    a = sensed + noise * NOISE["force"] * rng.standard_normal((n, 3))
    half = 0.5 * noise * NOISE["attitude"] / np.sqrt(3.0) * rng.standard_normal((n, 3))
    q = np.array([_product(x, np.concatenate([[1.0], h])) for x, h in zip(q, half, strict=True)])
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    for names, values in (
        (("px", "py", "pz"), p), (("qw", "qx", "qy", "qz"), q), (("vx", "vy", "vz"), v), (("wx", "wy", "wz"), w),
        (("ax", "ay", "az"), a), ([f"cmd_rotor_{k}" for k in range(rotors)], commands[:, :rotors]),
        ([f"cmd_tilt_{k}" for k in range(tilts)], commands[:, rotors:]),
    ):  # fmt: skip
        columns.update(dict(zip(names, np.asarray(values).T, strict=True)))
    return pd.DataFrame(columns)


def _product(p, q):
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


@njit(cache=True)
def _matrix(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@njit(cache=True)
def _cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@njit(cache=True)
def _turn(axis, angle, v):
    c, s = np.cos(angle), np.sin(angle)
    return c * v + s * _cross(axis, v) + (1 - c) * np.dot(axis, v) * axis


@njit(cache=True)
def _wrench(
    p, v, q, w, time, rotor, tilt, k_f, position, axis, kappa, tilt_of, tilt_axis, lower, radius, ring, effects
):
    drag, ground, sag, interference, scale = effects[0], effects[1], effects[2], effects[3], effects[5]
    r = _matrix(q)
    body_velocity = r.T @ v
    force, torque = np.zeros(3), np.zeros(3)
    arms = len(tilt_axis)
    lost = np.zeros(arms)
    if interference > 0.0 and arms > 0:
        arm = np.zeros(arms)
        for k in range(len(k_f)):
            arm[tilt_of[k]] += k_f[k] * rotor[k] ** 2
        for j in range(arms):
            before, here, after = ring[j - 1], ring[j], ring[(j + 1) % arms]
            lost[here] = (
                interference
                * (max(0.0, np.sin(tilt[before])) ** 2 * arm[before] + max(0.0, -np.sin(tilt[after])) ** 2 * arm[after])
                / np.mean(arm)
            )
    for k in range(len(k_f)):
        d, at = axis[k], position[k]
        if tilt_of[k] >= 0:
            about, angle = tilt_axis[tilt_of[k]], tilt[tilt_of[k]]
            d, at = _turn(about, angle, d), _turn(about, angle, at)
        thrust = k_f[k] * rotor[k] ** 2 * scale * (1.0 - sag * time)
        if ground > 0.0:
            height = p[2] + np.dot(r[2], at)
            thrust *= 1.0 + ground * (radius[k] / max(height, 0.05)) ** 2
        if tilt_of[k] >= 0:
            thrust *= 1.0 - lost[tilt_of[k]]
        force += thrust * d
        torque += thrust * (_cross(at, d) - kappa[k] * d)
    return force - drag * body_velocity, torque


@njit(cache=True)
def _loop(t, rp, rv, ra, rangle, rangle_rate, mass, inertia, gravity, position, axis, k_f, kappa, tau_rotor, tilt_of,
          tilt_axis, tau_tilt, rate_tilt, lower, radius, ring, inverse, effects, noise):  # fmt: skip
    n, rotors, tilts = len(t), len(k_f), len(tilt_axis)
    state, sensed, commands = np.zeros((n, 13)), np.zeros((n, 3)), np.zeros((n, rotors + tilts))
    inverse_inertia = np.linalg.inv(inertia)
    p, v, w = rp[0].copy(), rv[0].copy(), np.zeros(3)
    q = np.array([1.0, 0.0, 0.0, 0.0])
    rotor, tilt = np.zeros(rotors), np.zeros(tilts)
    extra, delay = effects[4], int(effects[6])
    up = np.array([0.0, 0.0, 1.0])
    integral = np.zeros(3)
    for k in range(n):
        r = _matrix(q)
        seen_p, seen_v = p + 0.001 * noise[k, :3], v + 0.005 * noise[k, 3:6]
        seen_w = w + 0.01 * noise[k, 6:9]
        integral += 0.005 * np.clip(rp[k] - seen_p, -0.3, 0.3)
        push = ra[k] + 6.0 * (rp[k] - seen_p) + 4.0 * (rv[k] - seen_v) + 2.0 * integral + gravity * up
        roll, pitch, yaw = rangle[k]
        if tilts == 0:
            z = push / np.linalg.norm(push)
            x = np.array([np.cos(yaw), np.sin(yaw), 0.0])
            y = _cross(z, x)
            y /= np.linalg.norm(y)
            x = _cross(y, z)
        else:
            x = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
            side = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
            y = np.cos(roll) * side + np.sin(roll) * _cross(x, side)
            z = _cross(x, y)
        wanted = np.empty((3, 3))
        wanted[:, 0], wanted[:, 1], wanted[:, 2] = x, y, z
        e = r.T @ wanted - wanted.T @ r
        error = 0.5 * np.array([e[2, 1], e[0, 2], e[1, 0]])
        stiff, damp = (80.0, 16.0) if tilts == 0 else (25.0, 9.0)
        torque = inertia @ (stiff * error - damp * seen_w)
        force = mass * (r.T @ push)
        if tilts == 0:
            force[0], force[1] = 0.0, 0.0
        demand = np.concatenate((force, torque))
        parts = inverse @ demand
        for j in range(tilts):
            c, s = 0.0, 0.0
            for i in range(rotors):
                if tilt_of[i] == j:
                    c += parts[i]
                    s += parts[rotors + i]
            last = commands[k - 1, rotors + j] if k > 0 else 0.0
            commands[k, rotors + j] = last + (np.arctan2(s, c) - last + np.pi) % (2 * np.pi) - np.pi
        for i in range(rotors):
            angle = commands[k, rotors + tilt_of[i]] if tilt_of[i] >= 0 else 0.0
            thrust = parts[i] * np.cos(angle) + parts[rotors + i] * np.sin(angle)
            commands[k, i] = np.sqrt(max(thrust, 0.0) / k_f[i])
        if k == 0:
            rotor[:], tilt[:] = commands[0, :rotors], commands[0, rotors:]
        f, _ = _wrench(p, v, q, w, t[k], rotor, tilt, k_f, position, axis, kappa, tilt_of, tilt_axis, lower, radius,
                       ring, effects)  # fmt: skip
        state[k, :3], state[k, 3:6], state[k, 6:10], state[k, 10:] = p, v, q, w
        sensed[k] = f / mass
        if k == n - 1:
            break
        acting = commands[max(k - delay, 0)]
        h = (t[k + 1] - t[k]) / SUBSTEPS
        for sub in range(SUBSTEPS):
            now = t[k] + sub * h
            for half in range(2):
                # actuators to the middle of the step, where the wrench is taken, and to its end
                for i in range(rotors):
                    target = acting[i]
                    if tau_rotor[i] > 0.0:
                        rotor[i] = target + (rotor[i] - target) * np.exp(-0.5 * h / tau_rotor[i])
                    else:
                        rotor[i] = target
                for j in range(tilts):
                    tau, left = tau_tilt[j] + extra, 0.5 * h
                    gap = acting[rotors + j] - tilt[j]
                    near = rate_tilt[j] * tau
                    if abs(gap) > near:
                        full = (abs(gap) - near) / rate_tilt[j]
                        step = min(full, left)
                        tilt[j] += np.sign(gap) * rate_tilt[j] * step
                        left -= step
                        gap = acting[rotors + j] - tilt[j]
                    tilt[j] = acting[rotors + j] - gap * np.exp(-left / tau) if tau > 0.0 else acting[rotors + j]
                if half == 0:
                    f1, m1 = _wrench(p, v, q, w, now, rotor, tilt, k_f, position, axis, kappa, tilt_of, tilt_axis,
                                     lower, radius, ring, effects)  # fmt: skip
                    a1 = _matrix(q) @ f1 / mass - gravity * up
                    w_mid = w + 0.5 * h * inverse_inertia @ (m1 - _cross(w, inertia @ w))
                    q_mid = _step(q, w, 0.5 * h)
                    p_mid, v_mid = p + 0.5 * h * v, v + 0.5 * h * a1
                    f2, m2 = _wrench(p_mid, v_mid, q_mid, w_mid, now + 0.5 * h, rotor, tilt, k_f, position, axis, kappa,
                                     tilt_of, tilt_axis, lower, radius, ring, effects)  # fmt: skip
                    a2 = _matrix(q_mid) @ f2 / mass - gravity * up
                    w_next = w + h * inverse_inertia @ (m2 - _cross(w_mid, inertia @ w_mid))
                    q, p, v, w = _step(q, w_mid, h), p + h * v_mid, v + h * a2, w_next
    return state, sensed, commands


@njit(cache=True)
def _step(q, w, h):
    angle = np.linalg.norm(w) * h
    s = 0.5 * h if angle < 1e-12 else h * np.sin(0.5 * angle) / angle
    c = np.cos(0.5 * angle)
    x, y, z = s * w[0], s * w[1], s * w[2]
    out = np.array(
        [
            q[0] * c - q[1] * x - q[2] * y - q[3] * z,
            q[0] * x + q[1] * c + q[2] * z - q[3] * y,
            q[0] * y - q[1] * z + q[2] * c + q[3] * x,
            q[0] * z + q[1] * y - q[2] * x + q[3] * c,
        ]
    )
    return out / np.linalg.norm(out)
