"""Effects on what the IMU measures. They show in the recorded motion against the IMU, not in the physics."""

from __future__ import annotations

from dataclasses import replace

from infotraj import rotations
from infotraj.dynamics.inputs import command_columns, input_columns
from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.effects.channels import missing_channel
from infotraj.effects.laws import ActuatorLaw, ImuLaw
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class GyroBias(Effect):
    """Measured rate = true rate + b, constant over a flight."""

    name = "gyro_bias"
    place = "measurement"
    exact = True
    parameters = (Parameter("b", "rad/s", 0.03, (-0.5, 0.5), size=3),)
    b: Array
    needs = ("gyro", "attitude")
    source = "Farrenkopf (1978); Titterton and Weston, Strapdown Inertial Navigation Technology, 12"
    hidden_when = "the rates are derived from the attitude"

    def imu(self, law: ImuLaw) -> ImuLaw:
        return replace(law, rate_bias=law.rate_bias + self.b)


class AccelerometerBias(Effect):
    """Measured specific force = true specific force + b, constant over a flight."""

    name = "accelerometer_bias"
    place = "measurement"
    exact = True
    parameters = (Parameter("b", "m/s^2", 0.1, (-3.0, 3.0), size=3),)
    b: Array
    needs = ("accelerometer",)
    source = "Titterton and Weston, Strapdown Inertial Navigation Technology, 12"
    day = 0.3  # 3 mg: a cheap sensor's offset, from one start to the next and with its temperature
    linear = True
    hidden_when = "the specific force is derived from the velocity"

    def imu(self, law: ImuLaw) -> ImuLaw:
        return replace(law, force_bias=law.force_bias + self.b)


class ImuMisalignment(Effect):
    """What the IMU measures, rates and specific force, is R(rotvec) times the body's: it is mounted askew."""

    name = "imu_misalignment"
    place = "measurement"
    exact = True
    parameters = (Parameter("rotvec", "rad", 0.0175, (-0.3, 0.3), size=3),)
    rotvec: Array
    needs = ("gyro", "accelerometer")
    source = "Titterton and Weston, Strapdown Inertial Navigation Technology, 12 (mounting misalignment)"
    declared = Declared("angle", 1 / 10, "frame of the IMU, turned about {axis} by", most=1.0)  # 0.1 deg, of a mount
    hidden_when = "rates and specific force are derived, not measured"

    def imu(self, law: ImuLaw) -> ImuLaw:
        return replace(law, rotation=rotations.matrix(rotations.exp(self.rotvec)) @ law.rotation)


class TimeOffset(Effect):
    """The IMU in row k was sampled at t[k] - dt: its clock runs behind the pose's, or filtering delays it.

    In a log without an accelerometer, whose rotors are measured, all of the motion was sampled so. Li and Mourikis,
    "Online temporal calibration for camera-IMU systems" (2014), 2, with the sign of the catalogue.
    """

    name = "time_offset"
    place = "measurement"
    parameters = (Parameter("dt", "s", 0.01, (-0.1, 0.1)),)
    dt: float
    source = "Li and Mourikis (2014), 2"
    declared = Declared("clock", 1 / 10, "clock of the sensors, later by")  # 1 ms: of log and sensor
    hidden_when = "rates or specific force are derived, not measured; not where rotors are measured and no force is"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        """Beside commands a pose that is late is not told from commands that act late."""
        without = missing_channel("accelerometer", vehicle, flight)
        if without is not None and _measured(vehicle, flight):
            return None
        return missing_channel("gyro", vehicle, flight) or without

    def imu(self, law: ImuLaw) -> ImuLaw:
        return replace(law, delay=law.delay + self.dt)


class TelemetryOffset(Effect):
    """Rotors and tilts measured in row k were so at t[k] - dt: their telemetry is late, or filtering delays it."""

    name = "telemetry_offset"
    place = "measurement"
    parameters = (Parameter("dt", "s", 0.01, (-0.1, 0.1)),)
    dt: float
    needs = ("accelerometer",)
    source = "Li and Mourikis (2014), 2, for the actuators' samples in place of the IMU's"
    declared = Declared("clock", 1 / 10, "clock of the measured rotors, later by")  # 1 ms: of log and telemetry
    hidden_when = "rotors are commanded, not measured; without an accelerometer motion that is early does the same"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        return None if _measured(vehicle, flight) else "the flight's rotors are commanded, not measured"

    def actuators(self, law: ActuatorLaw) -> ActuatorLaw:
        return replace(law, telemetry=law.telemetry + self.dt)


class SensorLag(Effect):
    """Gyro and accelerometer pass a first-order filter before they are written: dy/dt = (true - y) / time_constant.

    The low-pass of the sensor or of the autopilot. A channel that was derived, not measured, has none.
    """

    name = "sensor_lag"
    place = "measurement"
    parameters = (Parameter("time_constant", "s", 0.008, (0.0, 0.1)),)
    time_constant: float
    needs = ("gyro or accelerometer",)
    source = "first-order low-pass filter; Franklin et al., Feedback Control of Dynamic Systems, 3.3"
    hidden_when = "rates and specific force are derived, not measured"

    def imu(self, law: ImuLaw) -> ImuLaw:
        return replace(law, lag=law.lag + self.time_constant)


def _measured(vehicle: Vehicle, flight: Flight) -> bool:
    """Whether a model takes the rotors' measured inputs: where there are no commands."""
    return input_columns(vehicle, flight) not in (None, command_columns(vehicle))
