"""The rotors' angular momentum."""

from __future__ import annotations

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, Parameter
from infotraj.effects.thrust import cancelling
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class Gyroscopic(Effect):
    """Torque -omega x H - dH/dt on the body, H = sum of rotor_inertia s w d, derivative in body axes.

    Bouabdallah, "Design and control of quadrotors" (2007), 2.3.2, for any thrust axes: dH/dt holds the change of the
    speeds and the turning of the axes with their tilts. The first term is perpendicular to omega: it does no work on
    the body.
    """

    name = "gyroscopic"
    place = "wrench"
    parameters = (Parameter("rotor_inertia", "kg m^2", 3e-5, (0.0, 2e-3), meaning="of one rotor about its axis"),)
    rotor_inertia: float
    needs = ("inertia", "rate", "rotor speed")
    needs_to_act = ("rate", "rotor speed")
    source = "Bouabdallah (2007), 2.3.2"
    hidden_when = "coaxial pairs turn at equal speed: their angular momenta cancel"
    linear = True

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return cancelling(vehicle, flight, "angular momenta")

    def rotor_momentum(self, along: Along) -> tuple[Array, Array]:
        rotors = along.vehicle.rotors
        spin = self.rotor_inertia * np.array([r.spin for r in rotors], dtype=float)
        momentum = np.einsum("nr,nri->ni", spin * along.speed, along.axis)
        slope = np.einsum("nr,nri->ni", spin * along.speed_slope, along.axis)
        for tilt, joint in enumerate(along.vehicle.tilts):
            turned = [r for r, rotor in enumerate(rotors) if rotor.tilt == tilt]
            held = np.einsum("nr,nri->ni", (spin * along.speed)[:, turned], along.axis[:, turned])
            slope += along.actuation.tilt_slope[:, tilt, None] * np.cross(joint.axis, held)
        return momentum, slope
