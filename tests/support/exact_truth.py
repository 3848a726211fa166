"""What the exact simulation simulates: a vehicle file's numbers, changed by effects as the catalogue defines them."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

Body = namedtuple("Body", "mass inertia com gravity")
Rotors = namedtuple(
    "Rotors",
    "position axis spin k_f moment tilt radius lower factor reaction inflow ground drag inertia tau interference "
    "hover exponent lift hub",
)
Tilts = namedtuple("Tilts", "axis tau limit play bias order")
Air = namedtuple("Air", "linear quadratic damping force torque wind centre")
Other = namedtuple("Other", "sag_rate sag_exponent volts_rate load length delay sensor_lag")


def truth_of(vehicle, pairs):
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
