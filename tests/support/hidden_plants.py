"""Plants with one effect hidden, flown without sensor noise, against the catalogue's model of the same effect."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from infotraj.control.thrust_vector import ThrustVectorController
from infotraj.control.tracking import TrackingController
from infotraj.diagnosis.measure.residual import flight_samples
from infotraj.effects import effect_class
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.robots.plant.hiding import hide
from infotraj.robots.plant.plant import Plant
from infotraj.robots.plant.sensors import Noise
from infotraj.trajectories.standard import Extent, standard
from infotraj.vehicle import Vehicle, load_vehicle

Named = Sequence[tuple[str, dict]]
QUIET = Noise(*(1e-5 * np.array([Noise().position, Noise().attitude, Noise().rate, Noise().specific_force])))
VEHICLES = {name: load_vehicle(f"config/vehicles/{name}.yaml") for name in ("omav", "quadrotor")}
FLOWN = {
    "omav": (("attitude", "low"), Extent(), TrackingController),
    "quadrotor": (("helix", "low"), Extent(low=0.15, tilt=0.0), ThrustVectorController),
}
# What the mean of ten samples of the usual sensors leaves: m/s^2, and rad/s over the 5 ms of a step.
NOISE = {"force": 0.1 / np.sqrt(10), "rate": 0.01 * np.sqrt(2) / 10, "turn": 0.0025, "push": 0.05}
POSE = ("px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz")

EFFECTS = {
    "omav": (
        ("mass_offset", {"dm": 0.2}),
        ("inertia_error", {"dxx": 0.012, "dyy": 0.012, "dzz": 0.02}),
        ("com_offset", {"r": [0.008, -0.005, 0.006]}),
        ("thrust_scale", {"factor": 0.92}),
        ("rotor_effectiveness", {"rotor": 5, "factor": 0.85}),
        ("coaxial_loss", {"fraction": 0.15}),
        ("axial_inflow", {"k": 2e-4}),
        ("ground_effect", {"k": 0.15}),
        ("battery_sag", {"rate": 0.004}),
        ("battery_sag", {"exponent": 1.0}),
        ("rotor_interference", {"k": 0.06}),
        ("rotor_lag", {"extra_time_constant": 0.03}),
        ("servo_lag", {"extra_time_constant": 0.03}),
        ("servo_rate_limit", {"max_rate": 3.0}),
        ("servo_backlash", {"half_width": 0.015}),
        ("servo_bias", {"bias": [0.017, -0.012, 0.02, 0.009, -0.015, 0.013]}),
        ("actuation_delay", {"delay": 0.013}),
        ("rotor_drag", {"k": 6e-5}),
        ("linear_drag", {"d": [0.4, 0.5, 0.3]}),
        ("quadratic_drag", {"d": [0.25, 0.3, 0.2]}),
        ("angular_damping", {"d": [0.06, 0.05, 0.07]}),
        ("steady_force", {"f": [0.9, -0.6, 0.4]}),
        ("steady_torque", {"t": [0.1, -0.08, 0.06]}),
        ("suspended_load", {"mass": 0.4, "length": 0.6}),
        ("gyro_bias", {"b": [0.03, -0.02, 0.025]}),
        ("imu_misalignment", {"rotvec": [0.012, -0.01, 0.009]}),
        ("time_offset", {"dt": 0.012}),
        ("translational_lift", {"k": 6e-3}),
        ("thrust_exponent", {"n": 2.2}),
        ("sensor_lag", {"time_constant": 0.01}),
        ("accelerometer_bias", {"b": [0.2, -0.1, 0.15]}),
    ),
    "quadrotor": (
        ("mass_offset", {"dm": 0.04}),
        ("inertia_error", {"dxx": 0.0012, "dyy": 0.0009, "dzz": 0.0008}),
        ("com_offset", {"r": [0.004, -0.003, 0.003]}),
        ("thrust_scale", {"factor": 0.92}),
        ("rotor_effectiveness", {"rotor": 2, "factor": 0.85}),
        ("moment_scale", {"factor": 0.7}),
        ("axial_inflow", {"k": 1e-4}),
        ("ground_effect", {"k": 0.15}),
        ("battery_sag", {"rate": 0.004}),
        ("battery_sag", {"exponent": 1.0}),
        ("rotor_lag", {"extra_time_constant": 0.03}),
        ("actuation_delay", {"delay": 0.015}),
        ("rotor_drag", {"k": 3e-5}),
        ("linear_drag", {"d": [0.12, 0.15, 0.08]}),
        ("quadratic_drag", {"d": [0.08, 0.1, 0.05]}),
        ("angular_damping", {"d": [0.006, 0.005, 0.007]}),
        ("gyroscopic", {"rotor_inertia": 3e-5}),
        ("steady_force", {"f": [0.15, -0.1, 0.12]}),
        ("steady_torque", {"t": [0.01, -0.008, 0.006]}),
        ("suspended_load", {"mass": 0.08, "length": 0.5}),
        ("gyro_bias", {"b": [0.03, -0.02, 0.025]}),
        ("imu_misalignment", {"rotvec": [0.012, -0.01, 0.009]}),
        ("time_offset", {"dt": 0.01}),
        ("hub_moment", {"k": 1e-5}),
        ("translational_lift", {"k": 4e-3}),
        ("thrust_exponent", {"n": 1.8}),
        ("sensor_lag", {"time_constant": 0.008}),
        ("accelerometer_bias", {"b": [-0.15, 0.2, 0.1]}),
    ),
}


# What acts only beside another, with what stands beside it.
BESIDE = {
    "omav": (
        ("wind", {"v": [3.0, -2.0, 0.5]}, ("linear_drag", {"d": [0.4, 0.5, 0.3]})),
        ("wind", {"v": [3.0, -2.0, 0.5]}, ("quadratic_drag", {"d": [0.25, 0.3, 0.2]})),
        ("wind", {"v": [3.0, -2.0, 0.5]}, ("rotor_drag", {"k": 6e-5})),
        ("wind", {"v": [3.0, -2.0, 0.5]}, ("axial_inflow", {"k": 2e-4})),
        ("wind", {"v": [3.0, -2.0, 0.5]}, ("translational_lift", {"k": 6e-3})),
        ("pressure_centre", {"r": [0.02, -0.03, 0.04]}, ("linear_drag", {"d": [0.4, 0.5, 0.3]})),
    ),
    "quadrotor": (
        ("wind", {"v": [2.5, -2.0, 0.5]}, ("linear_drag", {"d": [0.12, 0.15, 0.08]})),
        ("wind", {"v": [2.5, -2.0, 0.5]}, ("rotor_drag", {"k": 3e-5})),
        ("wind", {"v": [2.5, -2.0, 0.5]}, ("translational_lift", {"k": 4e-3})),
        ("wind", {"v": [2.5, -2.0, 0.5]}, ("hub_moment", {"k": 1e-5})),
        ("pressure_centre", {"r": [0.02, -0.015, 0.03]}, ("quadratic_drag", {"d": [0.08, 0.1, 0.05]})),
    ),
}


def vehicle_for(name: str, values: dict) -> Vehicle:
    """The vehicle; with a nominal voltage where the effect is one of the voltage."""
    voltage = {"nominal_voltage": 16.0} if "exponent" in values else {}
    return VEHICLES[name].model_copy(update=voltage)


def flights(name: str, effect: str | None, values: dict, seconds: float = 4.0, beside: Named = ()) -> list[Flight]:
    """Flights with exact poses and velocities in every row, and all but noiseless sensors."""
    vehicle, (kinds, extent, controller) = vehicle_for(name, values), FLOWN[name]
    if effect == "suspended_load" and name == "quadrotor":
        extent = Extent(pace=0.6, low=0.15, tilt=0.0)  # a load that swings wide is unpredictable
    truth = hide(vehicle, [*beside, *([(effect, values)] if effect else [])])
    made = []
    for kind in kinds:
        reference = standard(kind, seconds, extent, np.random.default_rng(3))
        plant = Plant(vehicle, truth, settle=3.0 if effect == "suspended_load" else 1.5, noise=QUIET)
        flight, motion = plant.fly_with_truth(reference, controller(vehicle, reference), np.random.default_rng(0))
        made.append(Flight(flight.table.assign(**{c: motion[c].to_numpy() for c in POSE}), flight.meta))
    return made


def left(name: str, found: list[Flight], effect: str | None, values: dict, beside: Named = ()) -> float:
    """Largest root mean square of the residual over all axes, as 50 ms means, in units of the usual sensors' noise."""
    vehicle = vehicle_for(name, values)
    known = [*beside, *([(effect, values)] if effect else [])]
    model = Model(vehicle, [effect_class(n)(**v) for n, v in known])
    parts: dict[str, list] = {}
    for flight in found:
        samples = flight_samples(Model(vehicle), flight)
        for channel, residual in zip(samples.channels, samples.residual(model), strict=True):
            whole = residual[: len(residual) // 10 * 10].reshape(-1, 10, 3).mean(axis=1)
            parts.setdefault(channel.name, []).append(whole / NOISE[channel.name])
    return max(float(np.sqrt(np.mean(np.concatenate(p) ** 2, axis=0)).max()) for p in parts.values())


@cache
def floor(name: str) -> float:
    """What the model leaves of flights with nothing hidden: time steps of MuJoCo, servos of second order."""
    return left(name, flights(name, None, {}), None, {})
