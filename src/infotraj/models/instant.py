"""A model at one instant: the accelerations that actuators at rest at their commands would make in a given state.

This is what a controller inverts. Delays, lags, rate limits and play are left out: no command of the present undoes
what the actuators still have to do. Effects on the measurement (biases, misalignment, time offsets) are left out too:
they change what is seen, not what moves.
"""

from __future__ import annotations

import numpy as np

from infotraj import rotations
from infotraj.effects.along import Actuation, Along, Motion
from infotraj.effects.base import Effect, overrides
from infotraj.errors import InputError, problem
from infotraj.models import body
from infotraj.models.model import Model
from infotraj.models.rotor_wrench import forces_at_rotors, wrench_of_inputs
from infotraj.rotations import Array

_ACTS = ("thrust_factor", "thrust_loss", "reaction_factor", "rotor_force", "rotor_momentum", "wrench", "body", "air")


class Instant:
    """The specific force and angular acceleration of a model, state by state.

    left_out: names of the model's effects that do nothing here (lags, delays, play, effects on the measurement).
    InputError where an effect needs what no single state holds: a hanging load's swing, the battery's voltage.
    """

    def __init__(self, model: Model) -> None:
        acting = [e for e in model.effects if not e.is_absent(model.vehicle)]
        for effect in acting:
            self._check(effect)
        law = model.actuator_law
        self.vehicle = model.vehicle
        self._bias = law.tilt_bias
        self._body = model.body_law
        self._air = model.air_law
        self._wrench = wrench_of_inputs(model.vehicle)
        self._still = np.zeros((1, len(law.rotor_time_constant))), np.zeros((1, len(model.vehicle.tilts)))
        self._by_hook = {hook: [e for e in acting if overrides(e, hook)] for hook in _ACTS}
        self.left_out = tuple(e.name for e in acting if not (_instant(e) or e.shifts))

    def accelerations(self, time: float, state: Array, rotor: Array, tilt: Array) -> Array:
        """Specific force of the body's origin and angular acceleration (6,), m/s^2 and rad/s^2, body axes.

        time (s) since the flight's start; state (13,): position, attitude (w, x, y, z), velocity (world), rate (body);
        rotor (rotors,) rad/s, throttle or N, or the commanded wrench (6,), and tilt (tilts,) rad: commands that the
        actuators have reached.
        """
        attitude = rotations.matrix(state[3:7])
        rate = state[None, 10:13]
        motion = Motion(np.array([time]), attitude[None], state[2:3], (attitude.T @ state[7:10])[None], rate, None)
        actuation = Actuation(rotor[None], self._still[0], (tilt + self._bias)[None], self._still[1])
        along = Along(self.vehicle, motion, actuation, air=self._air)
        thrust, ratio = along.nominal_thrust, self._wrench.ratio
        for effect in self._by_hook["thrust_factor"]:
            thrust = thrust * effect.thrust_factor(along)
        for effect in self._by_hook["thrust_loss"]:
            thrust = thrust - effect.thrust_loss(along)
        for effect in self._by_hook["reaction_factor"]:
            ratio = ratio * effect.reaction_factor(along)
        object.__setattr__(along, "thrust", thrust)
        wrench = self._wrench(thrust, ratio, actuation)
        for effect in self._by_hook["wrench"]:
            wrench = wrench + effect.wrench(along)
        for effect in self._by_hook["rotor_force"]:
            wrench = wrench + forces_at_rotors(along.position, effect.rotor_force(along))
        force, torque = wrench[:, :3], wrench[:, 3:]
        for effect in self._by_hook["rotor_momentum"]:
            torque = torque - body.cross(rate, effect.rotor_momentum(along)[0])
        angular = body.angular_acceleration(self._body, force, torque, rate)
        return np.concatenate([body.specific_force(self._body, force, rate, angular)[0], angular[0]])

    def wrench(self, rotor: Array, tilt: Array) -> Array:
        """The rotors' own wrench (6,), N and N m about the body's origin, body axes, as the vehicle file has it."""
        actuation = Actuation(rotor[None], self._still[0], tilt[None], self._still[1])
        along = Along(self.vehicle, Motion(np.zeros(1), None, None, None, None, None), actuation)
        return self._wrench(along.nominal_thrust, self._wrench.ratio, actuation)[0]

    @staticmethod
    def _check(effect: Effect) -> None:
        what = None
        if overrides(effect, "load"):
            what = "how the load swings, which no single state says"
        elif effect.values.get("exponent"):
            what = "the battery's voltage, which the controller is not given"
        if what is not None:
            raise InputError(problem(f"{effect.name} in a controller needs {what}", "a model without it", "Remove it."))


def _instant(effect: Effect) -> bool:
    return any(overrides(effect, hook) for hook in _ACTS)
