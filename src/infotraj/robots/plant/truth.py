"""The truth file of a plant: everything in which the simulated vehicle differs from its vehicle file.

Nothing in the model, the learner or the controller reads it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from infotraj.errors import InputError, problem, unread
from infotraj.robots.plant.hidden import Hidden
from infotraj.vehicle import Inertia, NotNegative, Positive, Vector, Vehicle, validation_line

Fraction = Annotated[float, Field(ge=0, lt=1)]
NotNegativeVector = tuple[NotNegative, NotNegative, NotNegative]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Arm(_Strict):
    """What turns with one tilt: motors, propellers and their mount, centred on the tilt's axis."""

    mass: Positive = Field(description="kg, at the mean of its rotors' places on the axis; part of the total mass")
    inertia: tuple[Positive, Positive, Positive] = Field(
        description="kg m^2 about its centre: along the tilt's axis, across it, along the thrust"
    )
    bearing_damping: NotNegative = Field(0.0, description="N m s/rad, between the arm and the body")


class Rotors(_Strict):
    """What differs from rotor to rotor, in the order of the vehicle file, and the lag that all share."""

    thrust_factor: tuple[Positive, ...] = Field(description="true k_F over the file's, one a rotor")
    moment_factor: tuple[NotNegative, ...] = Field(description="true moment constant over the file's, one a rotor")
    rise_time_constant: NotNegative = Field(description="s, of a speed that grows")
    fall_time_constant: NotNegative = Field(description="s, of a speed that falls")
    inertia: NotNegative = Field(0.0, description="kg m^2, of one rotor about its axis: gyroscopic torques only")
    thrust_exponent: Positive = Field(2.0, description="of the speed in the thrust, which is the same in hover")


class Interference(_Strict):
    """Gaussian wakes of the other arms' rotors: width 0.7 R + spread x distance, loss `strength` at its source."""

    strength: Fraction = 0.0
    spread: NotNegative = 0.0


class Air(_Strict):
    """Aerodynamic effects that the model does not have (equations: docs/plants.md)."""

    coaxial_loss: Fraction = Field(0.0, description="share of thrust that lower rotors lose")
    interference: Interference = Interference()
    axial_inflow: NotNegative = Field(0.0, description="N s^2/(m rad)")
    rotor_drag: NotNegative = Field(0.0, description="N s^2/(m rad)")
    linear_drag: NotNegativeVector = Field((0.0, 0.0, 0.0), description="N s/m, body axes")
    quadratic_drag: NotNegativeVector = Field((0.0, 0.0, 0.0), description="N s^2/m^2, body axes")
    angular_damping: NotNegativeVector = Field((0.0, 0.0, 0.0), description="N m s/rad, body axes")
    wind: Vector = Field((0.0, 0.0, 0.0), description="m/s, of the air, world axes")
    pressure_centre: Vector = Field((0.0, 0.0, 0.0), description="m, where the body's drag acts, body axes")
    hub_moment: NotNegative = Field(0.0, description="N m s^2/(m rad): moment over speed and air across the rotor")
    translational_lift: NotNegative = Field(0.0, description="N s^2/m^2: thrust by the square of the air across")
    ground_effect: NotNegative = Field(0.0, description="thrust times 1 + this (R / height)^2")
    tilt_interference: NotNegative = Field(0.0, description="the catalogue's rotor_interference; not the wakes above")
    flapping: NotNegative = Field(0.0, description="s/m: in-plane force over thrust and speed across the rotor")
    hub_stiffness: NotNegative = Field(
        0.0, description="m: hub moment over in-plane force, from blades hinged off axis"
    )


class Blades(_Strict):
    """Stiff blades, of which rotors follow from blade-element momentum theory (`blade_elements`)."""

    count: Positive = Field(description="blades a rotor")
    root_chord: Positive = Field(description="m, at the axis; the chord is linear in the radius")
    tip_chord: Positive = Field(description="m")
    cutout: Fraction = Field(0.15, description="share of the radius that the hub takes")
    pitch: Positive = Field(description="m of advance a turn")
    lift_slope: Positive = Field(5.0, description="1/rad, of the section: c_l = slope sin a cos a")
    drag: Positive = Field(0.02, description="of the section at a = 0: c_d = this + drag_rise sin^2 a")
    drag_rise: Positive = Field(1.3, description="see drag")
    density: Positive = Field(1.2, description="kg/m^3, of the air")


class SecondOrder(_Strict):
    """A servo as an oscillator: natural frequency (rad/s) and damping ratio."""

    kind: Literal["second_order"] = "second_order"
    natural_frequency: Positive
    damping_ratio: Positive


class Lag(_Strict):
    """A servo as a dead time (s) and a first-order lag (s)."""

    kind: Literal["lag"] = "lag"
    time_constant: Positive
    dead_time: NotNegative = 0.0
    fast_time_constant: Positive = Field(
        1e-3, description="s, of the servo's own inertia against its damping: what makes the lag not quite first order"
    )


class Servos(_Strict):
    """The tilt servos: shared dynamics, and what differs from one to the next in the vehicle file's order."""

    dynamics: Annotated[SecondOrder | Lag, Field(discriminator="kind")]
    max_rate: Positive = Field(description="rad/s")
    zero_error: tuple[float, ...] = Field(description="rad, true tilt at command 0, one a tilt")
    play: tuple[NotNegative, ...] = Field(description="rad, half width, one a tilt; 0: none")


class Truth(_Strict):
    """One plant: the true body, arms, rotors, air and servos. SI units, body frame."""

    name: str
    vehicle: str = Field(description="name of the vehicle file that this plant belongs to")
    mass: Positive = Field(description="kg, with arms")
    center_of_mass: Vector = Field(description="m from the body's origin, at zero tilts")
    inertia: Inertia = Field(description="kg m^2 about the centre of mass, with arms, at zero tilts")
    arm: Arm | None = Field(None, description="left out for a vehicle without tilts")
    rotors: Rotors
    blades: Blades | None = Field(None, description="left out: thrust is k_F w^2 and the moment constant its torque")
    air: Air = Air()
    servos: Servos | None = Field(None, description="left out for a vehicle without tilts")
    hidden: Hidden = Hidden()

    @property
    def flying_mass(self) -> float:
        """kg that the rotors carry: the vehicle and what hangs from it."""
        return self.mass + (self.hidden.load.mass if self.hidden.load else 0.0)

    def tilting(self) -> tuple[Servos, Arm]:
        """The servos and the arm of a vehicle with tilts, which `check` asks for."""
        assert self.servos is not None
        assert self.arm is not None
        return self.servos, self.arm

    @classmethod
    def ideal(cls, vehicle: Vehicle) -> Truth:
        """The plant without hidden effects: what the vehicle file says, on arms of almost no mass.

        InputError where the vehicle file leaves out mass, inertia or a speed input, or gives rotors or tilts
        different time constants (a plant has one of each).
        """
        mass, inertia = vehicle.known_mass(), vehicle.known_inertia()
        rotor_lags = {r.time_constant for r in vehicle.rotors}
        servo_lags = {(t.time_constant, t.max_rate) for t in vehicle.tilts}
        if len(rotor_lags) > 1 or len(servo_lags) > 1:
            raise InputError(
                problem(
                    f"vehicle {vehicle.name}: rotors or tilts with different time constants or rate limits",
                    "one time constant for all rotors, one time constant and rate limit for all tilts",
                    "Make them equal.",
                )
            )
        n, m = len(vehicle.rotors), len(vehicle.tilts)
        lag = rotor_lags.pop()
        servos = None
        if m:
            time_constant, max_rate = servo_lags.pop()
            servos = Servos(
                dynamics=Lag(time_constant=time_constant or 1e-3),
                max_rate=min(max_rate, 1e3),
                zero_error=(0.0,) * m,
                play=(0.0,) * m,
            )
        return cls(
            name=f"{vehicle.name}_ideal",
            vehicle=vehicle.name,
            mass=mass,
            center_of_mass=vehicle.center_of_mass,
            inertia=inertia,
            arm=Arm(mass=1e-4, inertia=(1e-7, 1e-7, 1e-7)) if m else None,
            rotors=Rotors(
                thrust_factor=(1.0,) * n, moment_factor=(1.0,) * n, rise_time_constant=lag, fall_time_constant=lag
            ),
            servos=servos,
        )

    def check(self, vehicle: Vehicle, source: str) -> None:
        """InputError unless this truth belongs to `vehicle` and has one number a rotor and a tilt."""
        counts = {
            "rotors.thrust_factor": (len(self.rotors.thrust_factor), len(vehicle.rotors)),
            "rotors.moment_factor": (len(self.rotors.moment_factor), len(vehicle.rotors)),
            "servos.zero_error": (len(self.servos.zero_error) if self.servos else 0, len(vehicle.tilts)),
            "servos.play": (len(self.servos.play) if self.servos else 0, len(vehicle.tilts)),
        }
        if self.vehicle != vehicle.name:
            raise InputError(
                problem(f"{source}: belongs to vehicle {self.vehicle}", f"{vehicle.name}", "Use its own vehicle file.")
            )
        for where, (found, expected) in counts.items():
            if found != expected:
                raise InputError(problem(f"{source}: {where} has {found} numbers", f"{expected}", "Correct it."))
        if vehicle.tilts and self.arm is None:
            raise InputError(problem(f"{source}: no `arm`", "`arm` for a vehicle with tilts", "Add it."))


def load_truth(path: str | Path, vehicle: Vehicle) -> Truth:
    """Reads a truth file (YAML) for `vehicle`. InputError, one line, where it is missing, broken or inconsistent."""
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(unread(path, error, "a truth file")) from error
    try:
        truth = Truth.model_validate(content)
    except ValidationError as error:
        raise InputError(f"{path}: {validation_line(error, Truth)}") from error
    truth.check(vehicle, str(path))
    return truth
