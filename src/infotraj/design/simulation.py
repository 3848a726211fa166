"""Flies a reference in simulation: the model, with what was found in it, under a controller that knows the file alone.

The body is integrated by the midpoint rule at the reference's step, rotors with their declared lag. What is
asked is whether the vehicle stays in its limits and its room, not how well it flies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from infotraj import rotations
from infotraj.control.thrust_vector import AGILE, ThrustVectorController, ThrustVectorGains
from infotraj.control.tracking import TrackingController
from infotraj.design.expected import Limits
from infotraj.design.inputs import own_inputs, stand_in
from infotraj.models import Model
from infotraj.models.instant import Instant
from infotraj.robots.robot import Estimate
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference

_LOST = 3.0  # m from the reference: it is lost
_SETTLING = 10.0  # s of hover before: the controller's integrals find what the file's errors ask for


@dataclass(frozen=True)
class Simulated:
    """position (n, 3) m, world; inputs (n, rotors); at_limit: share of the time in which a rotor is at its limit."""

    position: Array
    inputs: Array
    at_limit: float

    def away(self, reference: Reference) -> float:
        """The greatest distance (m) from the reference."""
        return float(np.linalg.norm(self.position - reference.position, axis=1).max())


def simulated(model: Model, reference: Reference, limits: Limits) -> Simulated | None:
    """The flight in simulation; None for a vehicle without rotors, whose limits nobody knows.

    Where rotors do not tilt, under soft gains and under firm ones: what a soft loop cannot hold against a weak rotor a
    firm one can, and what a firm one shakes up behind slow rotors a soft one holds. The nearer to the reference counts.
    InputError where an effect of the model needs what no single state holds (a load's swing).
    """
    vehicle = model.vehicle
    if not vehicle.rotors or vehicle.mass is None or vehicle.inertia is None:
        return None
    own = stand_in(vehicle)
    if vehicle.tilts:
        return _under(TrackingController(own, reference), model, reference, limits)
    tried = [
        _under(ThrustVectorController(own, reference, gains), model, reference, limits)
        for gains in (ThrustVectorGains(), AGILE)
    ]
    return min(tried, key=lambda s: s.away(reference))


def _under(
    controller: TrackingController | ThrustVectorController, model: Model, reference: Reference, limits: Limits
) -> Simulated:
    """The flight in simulation under one controller."""
    vehicle, acts = model.vehicle, Instant(model)
    dt = reference.dt
    lags = np.array([r.time_constant for r in vehicle.rotors])
    follow = 1.0 - np.exp(-dt / np.maximum(lags, 1e-6))
    state = np.concatenate([reference.position[0], reference.attitude[0], np.zeros(6)])
    state[7:10], state[10:] = reference.velocity[0], reference.rate[0]
    position, inputs = np.empty_like(reference.position), np.empty((len(reference.t), len(vehicle.rotors)))
    rotor: Array | None = None
    held = 0
    for step in range(-round(_SETTLING / dt), len(reference.t)):
        k = max(step, 0)
        time = float(reference.t[k])
        estimate = Estimate(state[:3].copy(), state[3:7].copy(), state[7:10].copy(), state[10:].copy())
        _, speed, tilt = controller.command(k, estimate)
        asked = own_inputs(vehicle, speed)
        allowed = np.clip(asked, np.minimum(limits.low, limits.high), limits.high)
        held += step >= 0 and bool(np.any(np.abs(allowed - asked) > 1e-9 * np.maximum(np.abs(asked), 1.0)))
        rotor = allowed if rotor is None else rotor + follow * (allowed - rotor)
        position[k], inputs[k] = state[:3], allowed
        if (step >= 0 and np.linalg.norm(state[:3] - reference.position[k]) > _LOST) or not np.isfinite(state).all():
            position[k:] = np.inf
            inputs[k:] = allowed
            break
        state = _step(acts, time, state, rotor, tilt, dt, vehicle.gravity)
    return Simulated(position, inputs, held / len(reference.t))


def _step(acts: Instant, time: float, state: Array, rotor: Array, tilt: Array, dt: float, gravity: float) -> Array:
    def slope(at: float, x: Array) -> Array:
        q = rotations.normalize(x[3:7])
        moved = np.concatenate([x[:3], q, x[7:]])
        a = acts.accelerations(at, moved, rotor, tilt)
        out = np.empty(13)
        out[:3] = x[7:10]
        out[3:7] = 0.5 * rotations.multiply(q, np.concatenate([[0.0], x[10:]]))
        out[7:10] = rotations.to_world(q, a[:3]) - [0.0, 0.0, gravity]
        out[10:] = a[3:]
        return out

    state = state + dt * slope(time + dt / 2, state + dt / 2 * slope(time, state))
    state[3:7] = rotations.normalize(state[3:7])
    return state
