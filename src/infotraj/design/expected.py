"""The flight that a reference would give: the motion as asked for, and the inputs that the model needs for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.comparing.shaken import told_by_velocity
from infotraj.design.inputs import commands
from infotraj.effects.channels import from_velocity
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, POSITION, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle

_CORRECTIONS = 2  # times that the inputs are corrected by what the model's effects take from them
_LEAST = 0.1  # of the hover thrust: a rotor that pushes less is at its lower end
_MORE = 1.15  # times the greatest input that was flown, where the file gives no limit


@dataclass(frozen=True)
class Limits:
    """The least and greatest input of each rotor, (rotors,), in its own unit."""

    low: Array
    high: Array

    def passed(self, inputs: Array) -> float:
        """By how much of its range the worst input (n, rotors) lies outside; 0 or less inside."""
        if not inputs.size:
            return 0.0
        span = np.maximum(self.high - self.low, 1e-12)
        return float(max(((self.low - inputs) / span).max(), ((inputs - self.high) / span).max()))


def limits(vehicle: Vehicle, flown: list[Flight]) -> Limits:
    """What the rotors can do: what the file says, else a little more than what was flown."""
    count = len(vehicle.rotors)
    columns = [f"cmd_rotor_{i}" for i in range(count)]
    seen = [f.get(*columns) for f in flown if count and f.has(*columns)]
    most = np.nanmax(np.concatenate(seen), axis=0) if seen else np.full(count, np.inf)
    hover = float(vehicle.mass or 0.0) * vehicle.gravity / max(count, 1)
    level = commands(vehicle, np.array([[0.0, 0.0, _LEAST * hover * count, 0.0, 0.0, 0.0]]))
    low = np.array([level[c][0] for c in columns]) if count else np.zeros(0)
    given = [r.max_speed if r.input == "speed" else 1.0 if r.input == "throttle" else None for r in vehicle.rotors]
    high = np.array([_MORE * m if g is None else g for g, m in zip(given, most, strict=True)], dtype=float)
    return Limits(low, high)


def expected(model: Model, reference: Reference, like: Flight) -> Flight:
    """The flight table (no noise) of a vehicle that follows the reference as the model has it.

    like: a flown flight; the same channels are logged, the battery falls as it did there, and what was derived there
    counts as derived here. The inputs are those of the file, corrected twice by what the model's effects change.
    """
    vehicle = model.vehicle
    back = rotations.conjugate(reference.attitude)
    force = rotations.to_world(back, reference.acceleration + np.array([0.0, 0.0, vehicle.gravity]))
    wanted = np.concatenate([force, reference.angular_acceleration], axis=1)
    inertia = vehicle.inertia_matrix() if vehicle.inertia is not None else np.eye(3)
    mass = vehicle.mass or 1.0
    asked = wanted.copy()
    flight = _table(vehicle, reference, force, _wrench(asked, reference.rate, mass, inertia), like)
    for _ in range(_CORRECTIONS if model.effects else 0):
        got = model.predict(flight)
        had = np.concatenate([got.specific_force, got.angular_acceleration], axis=1)
        asked += np.where(np.isfinite(had), wanted - had, 0.0)
        flight = _table(vehicle, reference, force, _wrench(asked, reference.rate, mass, inertia), like)
    return flight


def _wrench(asked: Array, rate: Array, mass: float, inertia: Array) -> Array:
    torque = asked[:, 3:] @ inertia + np.cross(rate, rate @ inertia)
    return np.concatenate([mass * asked[:, :3], torque], axis=1)


def _table(vehicle: Vehicle, reference: Reference, force: Array, wrench: Array, like: Flight) -> Flight:
    derived = set(like.meta.get("derived", ()) or ())
    columns: dict[str, Array] = {"t": reference.t}
    for names, values in (
        (POSITION, reference.position),
        (ATTITUDE, reference.attitude),
        (VELOCITY, reference.velocity),
        (RATE, reference.rate),
        (SPECIFIC_FORCE, force),
    ):
        if like.has(*names):
            columns.update(zip(names, values.T, strict=True))
    if like.has("battery"):
        volts = like.get("battery")[:, 0]
        known = np.isfinite(volts)
        columns["battery"] = np.interp(reference.t, like.t[known] - like.t[0], volts[known])
    given = commands(vehicle, wrench)
    measured = {c.removeprefix("cmd_"): x for c, x in given.items() if c.startswith("cmd_")}
    columns.update({c: x for c, x in given.items() if like.has(c)} or given)
    columns.update({c: x for c, x in measured.items() if like.has(c) and c not in COMMANDED_WRENCH})
    columns["airborne"] = np.ones(len(reference.t))
    meta = {"source": "design", "derived": [c for c in sorted(derived) if c in columns]}
    made = Flight(pd.DataFrame(columns), meta)
    return told_by_velocity(made) if from_velocity(like) else made
