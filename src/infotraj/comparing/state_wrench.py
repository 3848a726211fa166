"""The model's wrench at any state: exactly as the effects give it, and, where it allows that, as a linear form.

A rollout asks for the wrench at states that were never recorded, with the actuators that were. Along one flight that
wrench is a fixed part plus, for most effects, a form that is linear in a few functions of the state: body velocity and
rate (rotor drag, axial inflow, linear drag, angular damping, gyroscopic torque), the velocity times its size (quadratic
drag) and the entries of the attitude matrix (a force fixed in the world). Which of them count is found by probing the
model at random states, and the form is used only where it reproduces further probes to rounding; any other effect is
evaluated state by state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from infotraj import rotations
from infotraj.effects.along import Actuation, Along, Motion
from infotraj.effects.base import overrides
from infotraj.models import Model, body
from infotraj.models.actuation import actuation
from infotraj.models.prepared import Prepared
from infotraj.models.rotor_wrench import CommandedWrench, forces_at_rotors, rotor_wrench
from infotraj.rotations import Array

FEATURES = 18  # body velocity 3, rate 3, velocity times its size 3, attitude matrix 9 (row by row)
_PROBED = 48  # instants at which the form of the wrench is looked for
_SEED = 20240229  # the probes of a given model and flight are always the same
_ROUNDING = 1e-9  # share of the largest wrench


@dataclass(frozen=True)
class Instants:
    """Recorded inputs at N instants: time (N,) s since the first row, actuators, battery (N,) V or None."""

    time: Array
    actuation: Actuation
    battery: Array | None
    of_flight: Callable

    def part(self, rows: Array | slice) -> Instants:
        """The inputs at some of the instants."""
        a = self.actuation
        parts = Actuation(a.rotor[rows], a.rotor_slope[rows], a.tilt[rows], a.tilt_slope[rows])
        return Instants(self.time[rows], parts, None if self.battery is None else self.battery[rows], self.of_flight)


def instants(model: Model, prepared: Prepared, time: Array) -> Instants:
    """The recorded inputs at `time` (N,) s of the flight's clock, increasing."""
    law, imu = prepared.as_logged(model.actuator_law, model.imu_law)
    recorded = prepared.recorded
    battery = None
    if recorded.battery is not None:
        battery = recorded.battery.at(time)[:, 0]
    kept: dict = {}

    def of_flight(key, make):
        if key not in kept:
            kept[key] = make(prepared.origin_path(imu))
        return kept[key]

    actuators = actuation(recorded, law, time)
    return Instants(time - prepared.start, actuators, battery, of_flight)


def wrench(model: Model, inputs: Instants, height: Array, velocity: Array, attitude: Array, rate: Array) -> Array:
    """Force (N) and torque (N m) about the body's origin, body axes, (N, 6), at N instants and states.

    height (N,) m; velocity (N, 3) m/s, body axes; attitude (N, 3, 3) body to world; rate (N, 3) rad/s.
    """
    motion = Motion(inputs.time, attitude, height, velocity, rate, inputs.battery)
    along = Along(model.vehicle, motion, inputs.actuation, inputs.of_flight, air=model.air_law)
    acting = [e for e in model.effects if not e.is_absent(model.vehicle)]
    thrust = along.nominal_thrust
    for effect in acting:
        thrust = thrust * effect.thrust_factor(along)
    for effect in acting:
        thrust = thrust - effect.thrust_loss(along)
    commanded = CommandedWrench(model.vehicle) if model.vehicle.inputs == "wrench" else None
    ratio = commanded.ratio if commanded else np.array([-r.spin * r.moment_constant for r in model.vehicle.rotors])
    for effect in acting:
        ratio = ratio * effect.reaction_factor(along)
    if commanded:
        total = commanded(thrust, ratio, inputs.actuation)
    else:
        thrust = np.ascontiguousarray(thrust)
        total = rotor_wrench(along.position, along.axis, thrust, np.ascontiguousarray(thrust * ratio))
    along = replace(along, thrust=thrust)
    for effect in acting:
        if overrides(effect, "wrench"):
            total = total + effect.wrench(along)
        if overrides(effect, "rotor_force"):
            total = total + forces_at_rotors(along.position, effect.rotor_force(along))
        if overrides(effect, "rotor_momentum"):
            momentum, change = effect.rotor_momentum(along)
            total[:, 3:] -= body.cross(rate, momentum) + change
    loads = [e.load(along) for e in acting if overrides(e, "load")]
    if loads:
        law = model.body_law
        angular = body.angular_acceleration(law, total[:, :3], total[:, 3:], rate)
        free = body.specific_force(law, total[:, :3], rate, angular)
        for load, pull in zip(loads, body.pulls(law, loads, free), strict=True):
            total[:, :3] += pull[:, None] * load.direction
    return total


def features(velocity: Array, attitude: Array, rate: Array) -> Array:
    """The functions of the state (N, FEATURES) in which the wrench may be linear."""
    return np.concatenate([velocity, rate, np.abs(velocity) * velocity, attitude.reshape(-1, 9)], axis=1)


@dataclass(frozen=True)
class LinearForm:
    """wrench = fixed (N, 6) + parts (N, a, 6) over the active features, exact for this model and flight."""

    fixed: Array
    parts: Array


def active_features(model: Model, inputs: Instants) -> NDArray[np.intp] | None:
    """Which features (a,) the wrench is linear in along these instants; None where it is not linear in them."""
    rng = np.random.default_rng(_SEED)
    some = np.unique(np.linspace(0, len(inputs.time) - 1, _PROBED).round().astype(int))
    few = inputs.part(some)
    states = [_random_state(rng, len(some)) for _ in range(FEATURES + 8)]
    probes = [wrench(model, few, *s) for s in states]
    largest = max(float(np.abs(p).max()) for p in probes)
    if max(float(np.abs(p - probes[0]).max()) for p in probes) <= _ROUNDING * largest:
        return np.zeros(0, dtype=np.intp)
    design = np.stack([np.column_stack([np.ones(len(some)), features(*s[1:])]) for s in states], axis=1)
    right = np.stack(probes, axis=1)
    # The attitude's entries are not independent of 1 for one state, but they are over many; solved instant by instant.
    form = np.linalg.pinv(design[:, : FEATURES + 4]) @ right[:, : FEATURES + 4]
    missed = np.abs(design @ form - right).max()
    if not missed <= 1e-6 * largest:
        return None
    size = np.abs(form[:, 1:]).max(axis=(0, 2))
    return np.flatnonzero(size > 1e-7 * largest)


def linear_form(model: Model, inputs: Instants, active: NDArray[np.intp]) -> LinearForm:
    """The linear form at all instants, from as many probes as it has parts."""
    rng = np.random.default_rng(_SEED + 1)
    count = len(inputs.time)
    if len(active) == 0:
        return LinearForm(wrench(model, inputs, *_same(_random_state(rng, 1), count)), np.zeros((count, 0, 6)))
    states = [_random_state(rng, 1) for _ in range(len(active) + 1 + 2)]
    design = np.concatenate([np.column_stack([[1.0], features(*s[1:])[:, active]]) for s in states])
    probes = np.stack([wrench(model, inputs, *_same(s, count)) for s in states])
    form = np.einsum("ps,snc->npc", np.linalg.pinv(design), probes)
    return LinearForm(np.ascontiguousarray(form[:, 0]), np.ascontiguousarray(form[:, 1:]))


def _random_state(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array, Array]:
    """Height, body velocity, attitude matrix, rate: random, of ordinary size."""
    attitude = rotations.matrix(rotations.normalize(rng.standard_normal((count, 4))))
    height = rng.uniform(0.5, 3.0, count)
    return height, 2.0 * rng.standard_normal((count, 3)), attitude, 2.0 * rng.standard_normal((count, 3))


def _same(state: tuple[Array, Array, Array, Array], count: int) -> tuple[Array, ...]:
    return tuple(np.ascontiguousarray(np.broadcast_to(x, (count, *x.shape[1:]))) for x in state)
