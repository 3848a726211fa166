"""Sections of a truth file for what a study hides beyond body, rotors and air. Absent by default: nothing changes.

Definitions (frames, signs, order of action): the catalogue of effects. What is not in the catalogue says so.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from infotraj.vehicle import NotNegative, Positive, Vector

Zero = (0.0, 0.0, 0.0)


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Load(_Strict):
    """A point mass on a cable from the body's origin: a pendulum on a ball joint, on top of the truth's mass."""

    mass: Positive = Field(description="kg")
    length: Positive = Field(description="m")


class Slosh(_Strict):
    """A mass inside the body on springs along body x and y, part of the truth's totals. Not in the catalogue."""

    mass: Positive = Field(description="kg")
    place: Vector = Field(description="m, body axes, at rest")
    frequency: Positive = Field(description="Hz")
    damping_ratio: NotNegative = 0.05


class FlexibleArm(_Strict):
    """One arm that bends up and down at its root, its tip a point mass inside the totals. Not in the catalogue."""

    rotor: int = Field(ge=0, description="a rotor on the arm (place in the vehicle file)")
    tip_mass: Positive = Field(description="kg")
    frequency: Positive = Field(description="Hz, of the tip mass on the arm with the body held")
    damping_ratio: NotNegative = 0.03


class ImuErrors(_Strict):
    """What the IMU measures: R(rotvec) times filtered rate and specific force, plus their biases, all `delay` ago."""

    gyro_bias: Vector = Field(Zero, description="rad/s")
    accelerometer_bias: Vector = Field(Zero, description="m/s^2")
    rotvec: Vector = Field(Zero, description="rad")
    delay: NotNegative = Field(0.0, description="s, a whole number of time steps")
    lag: NotNegative = Field(0.0, description="s, time constant of a first-order filter of both")


class Turbulence(_Strict):
    """First-order Gauss-Markov force and torque in body axes, as Dryden's longitudinal spectrum (MIL-F-8785C)."""

    force: NotNegative = Field(0.0, description="N, standard deviation an axis")
    torque: NotNegative = Field(0.0, description="N m, standard deviation an axis")
    correlation_time: Positive = Field(0.5, description="s: length of the gusts over the speed of the air")


class Gusts(_Strict):
    """Gusts of a wind (`dryden`): what acts on the air's velocity sees them, and they push by `drag` beside.

    The mean wind is left out, and so is what `drag` would take from the vehicle's own motion: gusts alone hide nothing.
    """

    speed: Positive = Field(description="m/s, of the mean wind 6 m (20 ft) above the ground")
    height: Positive = Field(6.0, description="m above the ground")
    heading: float = Field(0.0, description="rad, where the wind goes")
    drag: NotNegative = Field(0.0, description="N s/m")


class Wall(_Strict):
    """A wall at world x = place: the rotors' wake recirculates along it. Not in the catalogue.

    Force (pull, 0, -sink) exp(-(place - x) / range) in world axes, torque `torque` times the same in world axes.
    """

    place: float = Field(description="m, world x")
    range: Positive = Field(description="m")
    pull: float = Field(description="N at the wall")
    sink: float = Field(description="N at the wall")
    torque: Vector = Field(Zero, description="N m at the wall, world axes")


class Disturbance(_Strict):
    """Wrenches at the body's origin that neither rotors nor drag make."""

    force: Vector = Field(Zero, description="N, world axes")
    torque: Vector = Field(Zero, description="N m, body axes")
    turbulence: Turbulence | None = None
    gusts: Gusts | None = None
    wall: Wall | None = None
    magnetic: Vector = Field(
        Zero, description="N m: torque magnetic x (world x axis, seen from the body); not in the catalogue"
    )


class Sag(_Strict):
    """Thrust times 1 - rate t, t from the flight's first row."""

    kind: Literal["rate"] = "rate"
    rate: float = Field(description="1/s")


class Pack(_Strict):
    """A battery: open-circuit voltage falls with the charge drawn, and the load's current drops more in its resistance.

    V = (full - slope q) - resistance I, q the charge drawn (A s), I = rotor power / V. Thrust times
    ((V / nominal - blind) / (1 - blind))^exponent. The channel `battery` holds V, `log_lag` late (first order), every
    `log_period`, to `log_step`. With blind = log_lag = log_step = 0 this is the catalogue's voltage form.
    """

    kind: Literal["pack"] = "pack"
    nominal: Positive = Field(description="V")
    full: Positive = Field(description="V, open circuit, at the first row")
    slope: NotNegative = Field(description="V/(A s)")
    resistance: NotNegative = Field(description="Ohm")
    power_coefficient: Positive = Field(description="W s^3/rad^3: electric power of a rotor over its speed cubed")
    exponent: float
    blind: float = Field(0.0, ge=0.0, lt=1.0)
    log_noise: NotNegative = Field(0.0, description="V, standard deviation of a sample")
    log_lag: NotNegative = Field(0.0, description="s")
    log_period: Positive = Field(0.005, description="s")
    log_step: NotNegative = Field(0.0, description="V")


Supply = Annotated[Sag | Pack, Field(discriminator="kind")]


class Hysteresis(_Strict):
    """Thrust times 1 + fraction z, z = speed through play of +- half_width over half_width. Not in the catalogue."""

    fraction: float
    half_width: Positive = Field(description="rad/s")


class Hidden(_Strict):
    """All of the above."""

    command_delay: NotNegative = Field(0.0, description="s, a whole number of time steps")
    backlash: NotNegative = Field(
        0.0, description="rad, half width of play that holds the arm by dry friction: the play operator, without bounce"
    )
    load: Load | None = None
    slosh: Slosh | None = None
    flexible_arm: FlexibleArm | None = None
    imu: ImuErrors = ImuErrors()
    disturbance: Disturbance = Disturbance()
    supply: Supply | None = None
    hysteresis: Hysteresis | None = None
