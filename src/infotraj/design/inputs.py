"""What the actuators have to do along a reference: commands of a vehicle's own kind for the wrench asked for."""

from __future__ import annotations

import numpy as np

from infotraj.dynamics.allocation import Allocation
from infotraj.dynamics.inputs import wrench_columns
from infotraj.flight import COMMANDED_WRENCH
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


def stand_in(vehicle: Vehicle) -> Vehicle:
    """The same rotors with a speed as input, so that a controller can allocate; a thrust T is a speed sqrt(T)."""
    if all(r.input == "speed" for r in vehicle.rotors):
        return vehicle
    changed = {"input": "speed", "thrust_coefficient": 1.0, "thrust_polynomial": None, "max_speed": None}
    rotors = tuple(r if r.input == "speed" else r.model_copy(update=changed) for r in vehicle.rotors)
    return vehicle.model_copy(update={"rotors": rotors})


def own_inputs(vehicle: Vehicle, speed: Array) -> Array:
    """Inputs (..., rotors) of the vehicle's own kind for speeds (..., rotors) of its stand-in."""
    out = np.array(speed, dtype=float)
    for i, r in enumerate(vehicle.rotors):
        if r.input == "speed":
            continue
        thrust = speed[..., i] ** 2
        out[..., i] = thrust if r.input == "thrust" else _throttle(np.array(r.thrust_polynomial), thrust)
    return out


def _throttle(polynomial: Array, thrust: Array) -> Array:
    """The throttle whose polynomial c0 + c1 x + c2 x^2 is the thrust (N); 0 where less is asked for."""
    c0, c1, c2 = polynomial
    rest = np.maximum(thrust - c0, 0.0)
    if abs(c2) < 1e-12 * max(abs(c1), 1e-300):
        return rest / c1
    return (-c1 + np.sqrt(np.maximum(c1**2 + 4 * c2 * rest, 0.0))) / (2 * c2)


def commands(vehicle: Vehicle, wrench: Array) -> dict[str, Array]:
    """Columns of a flight table for the wrench (n, 6), N and N m, body axes: rotors and tilts, or the wrench."""
    if vehicle.inputs == "wrench":
        wanted = wrench_columns(vehicle)
        return {c: wrench[:, i] for i, c in enumerate(COMMANDED_WRENCH) if c in wanted}
    speed, tilt = Allocation(stand_in(vehicle)).actuators(wrench)
    rotors = own_inputs(vehicle, speed)
    return {f"cmd_rotor_{i}": x for i, x in enumerate(rotors.T)} | {f"cmd_tilt_{i}": x for i, x in enumerate(tilt.T)}
