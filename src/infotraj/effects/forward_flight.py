"""What air across a rotor does beside drag: it rolls the hub, and it carries."""

from __future__ import annotations

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, Parameter
from infotraj.effects.thrust import cancelling
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_RADIUS = 0.1  # m: of the rotor to which the usual hub moment belongs


class HubMoment(Effect):
    """Moment -s k w v_perp on the body at each rotor, v_perp its air velocity across its axis, s its spin.

    The advancing blade lifts more than the retreating one: a rotor that turns counter-clockwise and flies ahead rolls
    to the left. Leishman, Principles of Helicopter Aerodynamics, 4.5 (stiff blades); as the rolling moment of RotorS.
    """

    name = "hub_moment"
    place = "wrench"
    parameters = (Parameter("k", "N m s^2/(m rad)", 1e-6, (0.0, 1e-4)),)
    k: float
    built = True
    needs = ("inertia", "velocity", "rate", "rotor speed")
    needs_to_act = ("velocity", "rate", "rotor speed")
    source = "Leishman, Principles of Helicopter Aerodynamics, 4.5; RotorS"
    hidden_when = "rotors on parallel axes turn at equal speed in opposite senses: their moments cancel"
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        # Tip speed and disc area at the same advance: the moment over w v grows with the fourth power of the radius.
        radii = [r.radius for r in vehicle.rotors if r.radius]
        return parameter.scale * (float(np.mean(radii)) / _RADIUS) ** 4 if radii else parameter.scale

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        return 0.0, 30.0 * cls.scale(vehicle, parameter)

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return cancelling(vehicle, flight, "hub moments")

    def wrench(self, along: Along) -> Array:
        spin = np.array([r.spin for r in along.vehicle.rotors], dtype=float)
        torque = -self.k * np.einsum("nr,nri->ni", spin * along.speed, along.velocity_across)
        return np.concatenate([np.zeros_like(torque), torque], axis=1)


class TranslationalLift(Effect):
    """A rotor's thrust grows by k v_perp^2, v_perp its air velocity across its axis: less induced velocity ahead.

    The first term in the advance ratio of momentum theory in forward flight at a given speed and pitch: Leishman,
    Principles of Helicopter Aerodynamics, 2.14.
    """

    name = "translational_lift"
    place = "thrust"
    parameters = (Parameter("k", "N s^2/m^2", 4e-3, (0.0, 0.1)),)
    k: float
    built = True
    needs = ("rotors", "velocity", "rate")
    needs_to_act = needs
    source = "Leishman, Principles of Helicopter Aerodynamics, 2.14"
    linear = True

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        carried = vehicle.mass / len(vehicle.rotors) if vehicle.mass and vehicle.rotors else 0.2
        return 0.02 * carried

    @classmethod
    def bounds(cls, vehicle: Vehicle, parameter: Parameter) -> tuple[float, float]:
        return 0.0, 25.0 * cls.scale(vehicle, parameter)

    def thrust_loss(self, along: Along) -> Array:
        return -self.k * np.einsum("nri,nri->nr", along.velocity_across, along.velocity_across)
