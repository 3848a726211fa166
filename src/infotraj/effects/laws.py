"""What effects may change of a model before a flight is evaluated: actuators, the air, the body, the IMU."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


@dataclass(frozen=True)
class ActuatorLaw:
    """How actuators follow their commands, in this order: delay, lag with rate limit, play, bias.

    delay (s); rotor_time_constant (rotors,) s, or (6,) of a commanded wrench; tilt_time_constant (tilts,) s;
    tilt_max_rate (tilts,) rad/s, inf for none; tilt_play (tilts,) rad, half the width; tilt_bias (tilts,) rad.
    late (s): by which the recorded motion is late, so that actuators, measured or commanded, are seen to act later;
    telemetry (s): by which measured actuators are late.
    """

    delay: float
    rotor_time_constant: Array
    tilt_time_constant: Array
    tilt_max_rate: Array
    tilt_play: Array
    tilt_bias: Array
    late: float = 0.0
    telemetry: float = 0.0

    @property
    def clocks(self) -> tuple[float, float, float]:
        """What shifts it in time."""
        return self.delay, self.late, self.telemetry

    @classmethod
    def declared(cls, vehicle: Vehicle) -> ActuatorLaw:
        """The response that the vehicle file declares."""
        none = np.zeros(len(vehicle.tilts))
        return cls(
            0.0,
            vehicle.input_time_constants,
            np.array([a.time_constant for a in vehicle.tilts]),
            np.array([a.max_rate for a in vehicle.tilts]),
            none,
            none,
        )


@dataclass(frozen=True)
class RotorMove:
    """Where the rotors of an arm are beside the vehicle file: the arm of the rotor with this number.

    torque (3,) m: of a unit of thrust, body axes at tilt 0, which a place across the axis makes; height (m): along it.
    """

    rotor: int
    torque: Array
    height: float = 0.0


@dataclass(frozen=True)
class AirLaw:
    """What the body flies through: wind (3,) m/s, world axes; pressure_centre (3,) m, body axes: where drag acts.

    moved: rotors that are not where the vehicle file has them.
    """

    wind: Array
    pressure_centre: Array
    moved: tuple[RotorMove, ...] = ()

    @classmethod
    def still(cls) -> AirLaw:
        """Air at rest, drag at the body's origin."""
        return cls(np.zeros(3), np.zeros(3))


@dataclass(frozen=True)
class BodyLaw:
    """mass (kg), inertia (3, 3) kg m^2 about the centre of mass, and that centre (3,) m from the body's origin.

    measured_at: m (3,), the point of the body, from its origin, that the specific force was measured at.
    mass and inertia are None where the vehicle file leaves them out.
    """

    mass: float | None
    inertia: Array | None
    center_of_mass: Array
    measured_at: Array = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def declared(cls, vehicle: Vehicle) -> BodyLaw:
        """The rigid body that the vehicle file declares."""
        inertia = None if vehicle.inertia is None else vehicle.inertia.matrix()
        return cls(vehicle.mass, inertia, np.array(vehicle.center_of_mass), measured_at=np.array(vehicle.measured_at))


@dataclass(frozen=True)
class ImuLaw:
    """What the IMU writes in row k: rotation @ (the body's at t[k] - delay), plus its biases.

    rotation (3, 3); delay (s); rate_bias (3,) rad/s, force_bias (3,) m/s^2; lag (s): time constant of the first-order
    filter that the body's rates and specific force pass first, 0 for none.
    """

    rotation: Array
    delay: float
    rate_bias: Array
    lag: float = 0.0
    force_bias: Array = field(default_factory=lambda: np.zeros(3))

    @cached_property
    def turned(self) -> bool:
        """Whether its axes are not the body's."""
        return not np.array_equal(self.rotation, np.eye(3))

    @property
    def of_rates(self) -> Hashable:
        """What the body's rates follow from: all but the bias of the accelerometer."""
        return self.delay, self.lag, self.rate_bias.tobytes(), self.rotation.tobytes()

    @property
    def of_force(self) -> Hashable:
        """What its specific force follows from: all but the bias of the gyroscope."""
        return self.delay, self.lag, self.force_bias.tobytes(), self.rotation.tobytes()

    def true(self, measured: Array, bias: Array) -> Array:
        """What the body's axes show of measured values (m, 3) with this bias (3,)."""
        unbiased = measured - bias if bias.any() else measured
        return unbiased @ self.rotation if self.turned else unbiased

    @classmethod
    def ideal(cls) -> ImuLaw:
        """An IMU along the body's axes, on time, unfiltered and without bias."""
        return cls(np.eye(3), 0.0, np.zeros(3))
