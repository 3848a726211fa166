"""What an effect sees of a flight: motion and actuators at N instants, with what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit

from infotraj.dynamics.actuators import turn_parts
from infotraj.effects.laws import AirLaw
from infotraj.rotation_matrices import turned_back
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class Motion:
    """Recorded motion of the body at N instants, what the flight does not say being None.

    time (N,) s since the flight's first row; attitude (N, 3, 3) body to world; height (N,) m of the body's origin;
    velocity (N, 3) m/s, body axes; rate (N, 3) rad/s, body axes; battery (N,) V.
    """

    time: Array
    attitude: Array | None
    height: Array | None
    velocity: Array | None
    rate: Array | None
    battery: Array | None


@dataclass(frozen=True)
class Actuation:
    """Actuators at N instants: rotor input (N, rotors), tilt (N, tilts) rad, and their slopes.

    The input is a speed (rad/s), a throttle or a thrust (N), as the vehicle says; of a vehicle that takes a wrench it
    is the wrench (N, 6), N and N m.
    """

    rotor: Array
    rotor_slope: Array
    tilt: Array
    tilt_slope: Array
    _kept: dict[str, Any] = field(default_factory=dict, repr=False)

    def keep(self, name: str, make: Callable[[], Any]) -> Any:
        """What follows from the actuators alone, made once."""
        if name not in self._kept:
            self._kept[name] = make()
        return self._kept[name]

    @property
    def turns(self) -> tuple[Array, Array]:
        """Cosine and sine of each tilt, (N, tilts) each."""
        return self.keep("turns", lambda: (np.cos(self.tilt), np.sin(self.tilt)))


@dataclass(frozen=True)
class OriginPath:
    """Specific force of the body's origin, m/s^2, world axes, from `start` to `stop` (s since the first row).

    at(time (N,) s) gives it, (N, 3), between the recorded samples. first_speed (m/s): the origin's at the start, NaN
    where the flight does not say. across(time (N,) s): two directions across all thrusts (N, 2, 3), world axes, and the
    specific force and the velocity (m/s) along them, (N, 2); None where the flight or the vehicle has none.
    """

    start: float
    stop: float
    first_speed: float
    at: Callable[[Array], Array]
    across: Callable[[Array], tuple[Array, Array, Array]] | None = None


@dataclass(frozen=True)
class Along:
    """Motion and actuators at N instants of a flight, body axes and SI units throughout."""

    vehicle: Vehicle
    motion: Motion
    actuation: Actuation
    of_flight: Callable[[Any, Callable[[OriginPath], Any]], Any] | None = None
    thrust: Array | None = None
    air: AirLaw = field(default_factory=AirLaw.still)
    _kept: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def count(self) -> int:
        """The number of instants N."""
        return len(self.motion.time)

    @property
    def time(self) -> Array:
        """Time (N,) s since the flight's first row."""
        return self.motion.time

    @property
    def attitude(self) -> Array:
        """Rotation (N, 3, 3), body to world."""
        return _known(self.motion.attitude, "attitude")

    @property
    def velocity(self) -> Array:
        """Velocity of the body's origin over the ground (N, 3) m/s, body axes."""
        return _known(self.motion.velocity, "velocity")

    @property
    def velocity_in_air(self) -> Array:
        """Velocity of the body's origin through the air (N, 3) m/s, body axes: R^T (v - wind)."""
        if not self.air.wind.any():
            return self.velocity
        return self._keep("origin", lambda: self.velocity - turned_back(self.attitude, self.air.wind))

    @property
    def rate(self) -> Array:
        """Angular velocity (N, 3) rad/s, body axes."""
        return _known(self.motion.rate, "rate")

    @property
    def tilt(self) -> Array:
        """Tilts of the arms (N, tilts) rad, play and bias included."""
        return self.actuation.tilt

    @property
    def nominal_thrust(self) -> Array:
        """k_F w^2, the polynomial of the throttle, or the commanded thrust (N, rotors), N, without any effect.

        Of a vehicle that takes a wrench: the share (N, 1) of it that acts, ones.
        """
        return self.actuation.keep("nominal_thrust", self._nominal_thrust)

    @property
    def speed(self) -> Array:
        """Rotor speeds (N, rotors) rad/s; of a rotor with another input sqrt(T / k_F)."""
        return self.actuation.keep("speeds", self._speeds)[0]

    @property
    def speed_slope(self) -> Array:
        """Their rate of change (N, rotors) rad/s^2."""
        return self.actuation.keep("speeds", self._speeds)[1]

    @property
    def root_of_thrust(self) -> tuple[Array, Array]:
        """Root of the nominal thrusts and its rate of change, each (N, rotors), sqrt(N) and sqrt(N)/s."""
        return self.actuation.keep("roots", lambda: self._rooted(np.ones(len(self.vehicle.rotors))))

    @property
    def position(self) -> Array:
        """Rotor positions (N, rotors, 3) m."""
        return self._frames()[0]

    @property
    def met_position(self) -> Array:
        """Where the air meets the rotors (N, rotors, 3) m: their positions, and what the file has wrong of them."""
        return self._met()[0]

    @property
    def axis(self) -> Array:
        """Thrust axes (N, rotors, 3), unit."""
        return self._frames()[1]

    @property
    def air_velocity(self) -> Array:
        """Velocity of the rotors through the air (N, rotors, 3) m/s: that of the origin + omega x p."""
        return self._rotors_in_air()[0]

    @property
    def axial_velocity(self) -> Array:
        """Its part along the thrust axis (N, rotors) m/s: v_r . d."""
        return self._rotors_in_air()[1]

    @property
    def velocity_across(self) -> Array:
        """Its part across the thrust axis (N, rotors, 3) m/s."""
        return self._keep("across", lambda: self.air_velocity - self.axial_velocity[..., None] * self.axis)

    @property
    def rotor_height(self) -> Array:
        """Heights of the rotors above z = 0 (N, rotors) m."""

        def height() -> Array:
            down = self.attitude[:, 2, :]
            return _known(self.motion.height, "height")[:, None] + np.einsum("ni,nri->nr", down, self.position)

        return self._keep("rotor_height", height)

    def _keep(self, name: str, make: Callable[[], Any]) -> Any:
        if name not in self._kept:
            self._kept[name] = make()
        return self._kept[name]

    def _rotors_in_air(self) -> tuple[Array, Array]:
        return self._keep("air", lambda: _air_velocity(self.velocity_in_air, self.rate, *self._met()))

    def _met(self) -> tuple[Array, Array]:
        position, axis = self._frames()
        return (self._keep("met", lambda: position + _moved(self)) if self.air.moved else position), axis

    def _frames(self) -> tuple[Array, Array]:
        return self.actuation.keep("frames", lambda: rotor_frames(self.vehicle, *self.actuation.turns))

    def _nominal_thrust(self) -> Array:
        x = self.actuation.rotor
        if self.vehicle.inputs == "wrench":
            return np.ones((len(x), 1))
        c0, c1, c2 = _thrust_polynomials(self.vehicle)
        thrust = c2 * x
        thrust += c1
        thrust *= x
        thrust += c0
        return np.asarray(thrust)

    def _speeds(self) -> tuple[Array, Array]:
        x, slope = self.actuation.rotor, self.actuation.rotor_slope
        derived = np.array([r.input != "speed" for r in self.vehicle.rotors])
        if not derived.any():
            return x, slope
        speed, rise = self._rooted(np.array([r.thrust_coefficient or np.nan for r in self.vehicle.rotors]))
        return np.where(derived, speed, x), np.where(derived, rise, slope)

    def _rooted(self, k_f: Array) -> tuple[Array, Array]:
        """sqrt(T / k_f) of the nominal thrusts and its slope, each (N, rotors)."""
        _, c1, c2 = _thrust_polynomials(self.vehicle)
        root = np.sqrt(np.maximum(self.nominal_thrust, 0.0) / k_f)
        with np.errstate(divide="ignore", invalid="ignore"):
            inner = (c1 + 2 * c2 * self.actuation.rotor) * self.actuation.rotor_slope
            rise = np.where(root > 0, inner / (2 * k_f * root), 0.0)
        return root, rise


def torque_arm(along: Along, rotor: int, r: Array) -> Array:
    """The torque (3,) m of a unit of a rotor's thrust, r at tilt 0, as the rotor is tilted, (3,) or (N, 3)."""
    tilt = along.vehicle.rotors[rotor].tilt
    if tilt is None:
        return r
    cosine, sine = along.actuation.turns
    return _arm(cosine[:, tilt], sine[:, tilt], turn_parts(along.vehicle.tilts[tilt].axis) @ r)


@njit(cache=True)
def _arm(cosine, sine, parts):
    """Arms (N, 3) of a constant, a cosine's and a sine's part (3, 3), one a row."""
    out = np.empty((len(cosine), 3))
    for n in range(len(cosine)):
        for i in range(3):
            out[n, i] = parts[0, i] + cosine[n] * parts[1, i] + sine[n] * parts[2, i]
    return out


def of_arm(vehicle: Vehicle, rotor: int) -> list[int]:
    """The rotors that share an arm with this one, itself among them: one tilt, or one place seen from above."""
    own = vehicle.rotors[rotor]

    def same(other) -> bool:
        if own.tilt is not None or other.tilt is not None:
            return own.tilt == other.tilt
        return all(abs(a - b) <= 1e-3 for a, b in zip(own.position[:2], other.position[:2], strict=True))

    return [i for i, r in enumerate(vehicle.rotors) if same(r)]


def _moved(along: Along) -> Array:
    """How far the rotors are from where the file has them, m: p of r = p x d, and along their axes d.

    (N, rotors, 3), or (1, rotors, 3) where no rotor tilts.
    """
    axis = along.axis if along.vehicle.tilts else along.axis[:1]
    out = np.zeros_like(axis)
    for move in along.air.moved:
        arm = torque_arm(along, move.rotor, move.torque)
        for i in of_arm(along.vehicle, move.rotor):
            out[:, i] += np.cross(axis[:, i], arm) + move.height * axis[:, i]
    return out


def rotor_frames(vehicle: Vehicle, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Rotor positions (m) and thrust axes, each (N, rotors, 3), for cosines and sines of tilts (N, tilts)."""
    of_rotor = np.array([-1 if r.tilt is None else r.tilt for r in vehicle.rotors])
    return _frames(cosine, sine, of_rotor, _frame_parts(vehicle))


def _thrust_polynomials(vehicle: Vehicle) -> Array:
    """Coefficients (3, rotors) of the thrust (N) in the rotor's input."""
    forms = {"speed": lambda r: (0.0, 0.0, r.thrust_coefficient), "thrust": lambda r: (0.0, 1.0, 0.0)}
    rows = [forms.get(r.input, lambda r: r.thrust_polynomial)(r) for r in vehicle.rotors]
    return np.array(rows, dtype=float).T


def _frame_parts(vehicle: Vehicle) -> Array:
    """Constant, cosine and sine part of every rotor's position and axis (Rodrigues), (rotors, 3 parts, 6)."""
    parts = np.zeros((len(vehicle.rotors), 3, 6))
    for i, rotor in enumerate(vehicle.rotors):
        for columns, vector in ((slice(0, 3), rotor.position), (slice(3, 6), rotor.axis)):
            if rotor.tilt is None:
                parts[i, 0, columns] = vector
                continue
            parts[i, :, columns] = turn_parts(vehicle.tilts[rotor.tilt].axis) @ vector
    return parts


@njit(cache=True)
def _frames(cosine, sine, of_rotor, parts):
    count, rotors = len(cosine), len(of_rotor)
    position, axis = np.empty((count, rotors, 3)), np.empty((count, rotors, 3))
    for n in range(count):
        for r in range(rotors):
            c, s = (cosine[n, of_rotor[r]], sine[n, of_rotor[r]]) if of_rotor[r] >= 0 else (0.0, 0.0)
            for i in range(3):
                position[n, r, i] = parts[r, 0, i] + c * parts[r, 1, i] + s * parts[r, 2, i]
                axis[n, r, i] = parts[r, 0, 3 + i] + c * parts[r, 1, 3 + i] + s * parts[r, 2, 3 + i]
    return position, axis


def _known(values: Array | None, what: str) -> Array:
    if values is None:
        raise ValueError(f"the flight has no {what}: an effect that reads it lists it in `needs_to_act`")
    return values


@njit(cache=True)
def _air_velocity(velocity, rate, position, axis):
    count, rotors = position.shape[:2]
    air, axial = np.empty((count, rotors, 3)), np.empty((count, rotors))
    for n in range(count):
        wx, wy, wz = rate[n, 0], rate[n, 1], rate[n, 2]
        for r in range(rotors):
            x, y, z = position[n, r, 0], position[n, r, 1], position[n, r, 2]
            a = velocity[n, 0] + wy * z - wz * y
            b = velocity[n, 1] + wz * x - wx * z
            c = velocity[n, 2] + wx * y - wy * x
            air[n, r, 0], air[n, r, 1], air[n, r, 2] = a, b, c
            axial[n, r] = a * axis[n, r, 0] + b * axis[n, r, 1] + c * axis[n, r, 2]
    return air, axial
