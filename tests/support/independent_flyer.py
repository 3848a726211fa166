"""Flies a reference and writes the flight table, sharing no code with infotraj: a stand-in for a real vehicle.

usage: python independent_flyer.py REFERENCE.csv VEHICLE.yaml FLIGHT.csv [SEED]

A rigid body, first-order rotors and rate-limited tilts, stepped at 1 kHz; a PD controller with the reference's
accelerations as feedforward at the reference's rate. Hidden from the vehicle file: the lower rotor of a coaxial pair
loses 6 % of its thrust, the centre of mass lies 4 mm off, and a constant torque of 0.15 N m acts about x.
"""

from __future__ import annotations

import csv
import sys

import numpy as np
import yaml

STEP = 1e-3
LOWER_ROTOR_LOSS = 0.06
MASS_OFFSET = np.array([0.004, -0.002, 0.0])
CONSTANT_TORQUE = np.array([0.15, 0.0, 0.0])
POSITION_GAINS, ATTITUDE_GAINS = (6.0, 4.0), (36.0, 11.0)


def cross_matrix(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def turn(axis, angle):
    """Rotation matrix by Rodrigues' formula."""
    k = cross_matrix(axis)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k)


def turn_by(rotvec):
    angle = np.linalg.norm(rotvec)
    return np.eye(3) if angle < 1e-15 else turn(rotvec / angle, angle)


def quaternion_to_matrix(q):
    w, v = q[0], q[1:]
    k = cross_matrix(v)
    return np.eye(3) + 2.0 * w * k + 2.0 * (k @ k)


def matrix_to_quaternion(r):
    """The eigenvector of the largest eigenvalue of Bar-Itzhack's matrix (2000): stable at every angle."""
    k = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    q = np.linalg.eigh(k)[1][:, -1]
    return q if q[0] >= 0 else -q


class Body:
    """Mass, geometry and actuators as the vehicle file gives them."""

    def __init__(self, content):
        self.mass, self.gravity = content["mass"], content.get("gravity", 9.81)
        i = content["inertia"]
        xy, xz, yz = (i.get(k, 0.0) for k in ("xy", "xz", "yz"))
        self.inertia = np.array([[i["xx"], xy, xz], [xy, i["yy"], yz], [xz, yz, i["zz"]]])
        self.rotors, self.tilts = content["rotors"], content.get("tilts", [])
        self.axes = [np.array(j["axis"], float) / np.linalg.norm(j["axis"]) for j in self.tilts]
        self.coefficient = np.array([r["thrust_coefficient"] for r in self.rotors])
        self.top_speed = np.array([r["max_speed"] for r in self.rotors])
        self.rotor_lag = np.array([r["time_constant"] for r in self.rotors])
        self.tilt_lag = np.array([j["time_constant"] for j in self.tilts])
        self.tilt_rate = np.array([j["max_rate"] for j in self.tilts])
        self.per_thrust = np.array([self._wrench(r) for r in self.rotors])
        self.allocation, self.columns = self._allocation()

    @staticmethod
    def _wrench(rotor):
        axis = np.array(rotor["axis"], float) / np.linalg.norm(rotor["axis"])
        torque = np.cross(rotor["position"], axis) - rotor["spin"] * rotor["moment_constant"] * axis
        return np.concatenate([axis, torque])

    def _turned(self, wrench, axis):
        return np.concatenate([np.cross(axis, wrench[:3]), np.cross(axis, wrench[3:])])

    def _allocation(self):
        """Pseudo-inverse of the map from (cosine, sine) parts of each thrust to the wrench."""
        columns, owners = [], []
        for k, rotor in enumerate(self.rotors):
            columns.append(self.per_thrust[k])
            owners.append((k, "cos"))
            if rotor.get("tilt") is not None:
                columns.append(self._turned(self.per_thrust[k], self.axes[rotor["tilt"]]))
                owners.append((k, "sin"))
        return np.linalg.pinv(np.array(columns).T), owners

    def command(self, wrench, last_tilt):
        """Rotor speeds and tilts for a wrench; tilts stay within half a turn of the last ones."""
        parts = np.zeros((len(self.rotors), 2))
        for value, (k, part) in zip(self.allocation @ wrench, self.columns, strict=True):
            parts[k, 0 if part == "cos" else 1] = value
        tilt = np.array(last_tilt)
        for j in range(len(tilt)):
            c, s = parts[[r.get("tilt") == j for r in self.rotors]].sum(axis=0)
            angle = np.arctan2(s, c)
            tilt[j] = last_tilt[j] + (angle - last_tilt[j] + np.pi) % (2.0 * np.pi) - np.pi
        angles = np.array([0.0 if r.get("tilt") is None else tilt[r["tilt"]] for r in self.rotors])
        thrust = np.maximum(parts[:, 0] * np.cos(angles) + parts[:, 1] * np.sin(angles), 0.0)
        return np.minimum(np.sqrt(thrust / self.coefficient), self.top_speed), tilt

    def true_wrench(self, speed, tilt):
        """Force and torque about the true centre of mass, hidden effects included."""
        total = np.zeros(6)
        turned = [turn(axis, angle) for axis, angle in zip(self.axes, tilt, strict=True)]
        for k, rotor in enumerate(self.rotors):
            thrust = self.coefficient[k] * speed[k] ** 2
            if rotor.get("coaxial") == "lower":
                thrust *= 1.0 - LOWER_ROTOR_LOSS
            r = np.eye(3) if rotor.get("tilt") is None else turned[rotor["tilt"]]
            total += thrust * np.concatenate([r @ self.per_thrust[k, :3], r @ self.per_thrust[k, 3:]])
        total[3:] += CONSTANT_TORQUE - np.cross(MASS_OFFSET, total[:3])
        return total


def control(body, reference, position, velocity, attitude, rate):
    """The commanded wrench (body axes) of a PD controller with feedforward."""
    kp, kd = POSITION_GAINS
    error, error_rate = reference["p"] - position, reference["v"] - velocity
    acceleration = reference["a"] + kp * error + kd * error_rate + np.array([0.0, 0.0, body.gravity])
    target = quaternion_to_matrix(reference["q"])
    skew = attitude.T @ target - target.T @ attitude
    attitude_error = 0.5 * np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    kr, kw = ATTITUDE_GAINS
    alpha = reference["alpha"] + kr * attitude_error + kw * (reference["w"] - rate)
    torque = body.inertia @ alpha + np.cross(rate, body.inertia @ rate)
    return np.concatenate([attitude.T @ (body.mass * acceleration), torque])


def fly(body, rows, rng):
    """The flight table's rows, one a row of the reference."""
    first = rows[0]
    position, velocity = first["p"].copy(), first["v"].copy()
    attitude, rate = quaternion_to_matrix(first["q"]), first["w"].copy()
    tilt, limits = np.zeros(len(body.tilts)), np.array([-body.tilt_rate, body.tilt_rate])
    speed = None
    lever = -MASS_OFFSET  # from the centre of mass, which the integration follows, to the body's origin
    position += attitude @ MASS_OFFSET
    velocity += attitude @ np.cross(rate, MASS_OFFSET)
    for k, reference in enumerate(rows):
        origin, origin_velocity = position + attitude @ lever, velocity + attitude @ np.cross(rate, lever)
        wrench = control(body, reference, origin, origin_velocity, attitude, rate)
        command_speed, command_tilt = body.command(wrench, tilt)
        if speed is None:
            speed, tilt = command_speed.copy(), command_tilt.copy()
        felt = body.true_wrench(speed, tilt)
        alpha = np.linalg.solve(body.inertia, felt[3:] - np.cross(rate, body.inertia @ rate))
        specific = felt[:3] / body.mass + np.cross(alpha, lever) + np.cross(rate, np.cross(rate, lever))
        seen = attitude @ turn_by(rng.normal(0.0, np.radians(0.1) / np.sqrt(3.0), 3))
        yield [
            reference["t"],
            *(origin + rng.normal(0.0, 0.001, 3)),
            *matrix_to_quaternion(seen),
            *(origin_velocity + rng.normal(0.0, 0.005, 3)),
            *(rate + rng.normal(0.0, 0.01, 3)),
            *(specific + rng.normal(0.0, 0.1, 3)),
            *wrench,
            *command_speed,
            *command_tilt,
            *speed,
            *tilt,
            *reference["p"],
            *reference["q"],
            1,
        ]
        span = rows[k + 1]["t"] - reference["t"] if k + 1 < len(rows) else 0.0
        steps = round(span / STEP)
        for _ in range(steps):
            h = span / steps
            speed = speed + (command_speed - speed) * -np.expm1(-h / body.rotor_lag)
            tilt = tilt + np.clip((command_tilt - tilt) * -np.expm1(-h / body.tilt_lag), *(h * limits))
            total = body.true_wrench(speed, tilt)
            rate = rate + h * np.linalg.solve(body.inertia, total[3:] - np.cross(rate, body.inertia @ rate))
            velocity = velocity + h * (attitude @ total[:3] / body.mass - np.array([0.0, 0.0, body.gravity]))
            position = position + h * velocity
            attitude = attitude @ turn_by(h * rate)


def main(reference_path, vehicle_path, flight_path, seed="0"):
    with open(vehicle_path) as file:
        body = Body(yaml.safe_load(file))
    names = {"p": ("px", "py", "pz"), "q": ("qw", "qx", "qy", "qz"), "v": ("vx", "vy", "vz")}
    names |= {"w": ("wx", "wy", "wz"), "a": ("ax", "ay", "az"), "alpha": ("alphax", "alphay", "alphaz")}
    with open(reference_path, newline="") as file:
        rows = [
            {"t": float(r["t"])} | {k: np.array([float(r[f"ref_{c}"]) for c in v]) for k, v in names.items()}
            for r in csv.DictReader(file)
        ]
    header = ["t", "px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az"]
    header += ["cmd_fx", "cmd_fy", "cmd_fz", "cmd_tx", "cmd_ty", "cmd_tz"]
    for prefix in ("cmd_", ""):
        header += [f"{prefix}rotor_{k}" for k in range(len(body.rotors))]
        header += [f"{prefix}tilt_{k}" for k in range(len(body.tilts))]
    header += ["ref_px", "ref_py", "ref_pz", "ref_qw", "ref_qx", "ref_qy", "ref_qz", "airborne"]
    with open(flight_path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for row in fly(body, rows, np.random.default_rng(int(seed))):
            writer.writerow([f"{value:.12g}" for value in row])


if __name__ == "__main__":
    main(*sys.argv[1:])
