"""The rotors' angular momentum."""

from __future__ import annotations

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, Parameter
from infotraj.effects.channels import missing_channel
from infotraj.effects.thrust import cancelling, hover_thrust
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_LEADS = 0.1  # s by which the reaction torque of a usual rotor leads what its thrust makes of it
_NO_RATIO = 0.01  # m: reaction torque over thrust, where the file gives none


class Gyroscopic(Effect):
    """Torque -omega x H - dH/dt on the body, H = sum of rotor_inertia s w d, derivative in body axes.

    Where the file says nothing of speeds, H = sum of momentum s sqrt(T) d: a speed goes with the root of the thrust,
    and what it is at 1 N is one number with the inertia. Beside a lag this is what makes a vehicle yaw at once: a rotor
    that is spun up pushes the body back.

    Bouabdallah, "Design and control of quadrotors" (2007), 2.3.2, for any thrust axes: dH/dt holds the change of the
    speeds and the turning of the axes with their tilts. The first term is perpendicular to omega: it does no work on
    the body.
    """

    name = "gyroscopic"
    place = "wrench"
    parameters = (
        Parameter("rotor_inertia", "kg m^2", 3e-5, (0.0, 2e-3), optional=True, meaning="of one rotor about its axis"),
        Parameter(
            "momentum", "N m s/sqrt(N)", 3e-3, (0.0, 1.0), optional=True, meaning="of one rotor at a thrust of 1 N"
        ),
    )
    rotor_inertia: float
    momentum: float
    built = True
    needs = ("inertia", "rate", "rotors")
    needs_to_act = ("rate", "rotors")
    source = "Bouabdallah (2007), 2.3.2"
    hidden_when = "coaxial pairs turn at equal speed: their angular momenta cancel"
    linear = True

    @classmethod
    def form(cls, vehicle: Vehicle, flight: Flight) -> tuple[Parameter, ...]:
        known = missing_channel("rotor speed", vehicle, flight) is None
        return cls.parameters[:1] if known else cls.parameters[1:]

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        if parameter.name == "rotor_inertia" or not vehicle.rotors or not vehicle.mass:
            return parameter.scale
        ratio = float(np.mean([abs(r.moment_constant) for r in vehicle.rotors])) or _NO_RATIO
        return 2.0 * _LEADS * ratio * float(np.sqrt(hover_thrust(vehicle)))

    def check(self, vehicle: Vehicle) -> None:
        super().check(vehicle)
        if self.rotor_inertia and self.momentum:
            raise InputError(problem(f"{self.name}: rotor_inertia and momentum", "one of them", "Remove the other."))

    def missing(self, vehicle: Vehicle, flight: Flight) -> str | None:
        without = missing_channel("rotor speed", vehicle, flight) if self.rotor_inertia else None
        return super().missing(vehicle, flight) or without

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return cancelling(vehicle, flight, "angular momenta")

    def rotor_momentum(self, along: Along) -> tuple[Array, Array]:
        rotors = along.vehicle.rotors
        spin = (self.rotor_inertia or self.momentum) * np.array([r.spin for r in rotors], dtype=float)
        speed, rise = (along.speed, along.speed_slope) if self.rotor_inertia else along.root_of_thrust
        momentum = np.einsum("nr,nri->ni", spin * speed, along.axis)
        slope = np.einsum("nr,nri->ni", spin * rise, along.axis)
        for tilt, joint in enumerate(along.vehicle.tilts):
            turned = [r for r, rotor in enumerate(rotors) if rotor.tilt == tilt]
            held = np.einsum("nr,nri->ni", (spin * speed)[:, turned], along.axis[:, turned])
            slope += along.actuation.tilt_slope[:, tilt, None] * np.cross(joint.axis, held)
        return momentum, slope
