"""A number of a log that is no effect of the catalogue: which point of the body its motion was measured at."""

from __future__ import annotations

from dataclasses import replace

from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.channels import missing_channel
from infotraj.effects.laws import BodyLaw
from infotraj.effects.rigid_body import arm_length
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_USUAL = 0.1  # of an arm: the middle of the markers stands beside the body's origin, or above it


class SensorPlace(Effect):
    """The force was measured r (body axes) from the body's origin, from the path of the point that was followed.

    It is f + dw x r + w x (w x r), and no torque follows: a centre of mass beside the origin moves the same, and tilts
    what the rotors' thrusts do. Along the thrusts the two are hardly told apart. An accelerometer stands where the file
    has its origin; the middle of a motion capture's markers does not.
    """

    name = "sensor_place"
    place = "measurement"
    exact = True
    parameters = (Parameter("r", "m", 0.02, (-1.0, 1.0), size=3),)
    r: Array
    needs = ("mass", "specific force", "rate")
    needs_to_act = ("rate",)
    source = "Featherstone (2008), 2.8: the acceleration of another point of a rigid body"
    linear = True
    hidden_when = "the force was measured by an accelerometer"
    declared = Declared("mount", 1.0, "measured_at.{axis}")

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        name, _, per = super().in_the_file(vehicle, place, rotor)
        return name, float(vehicle.measured_at[place]), per

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return cls.hidden_when if missing_channel("accelerometer", vehicle, flight) is None else None

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return _USUAL * arm_length(vehicle)

    def body(self, law: BodyLaw) -> BodyLaw:
        return replace(law, measured_at=law.measured_at + self.r)
