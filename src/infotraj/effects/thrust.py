"""Effects on the thrust of the rotors. T = k_F w^2 (or what the input gives) times every factor, minus every loss.

Of a vehicle that takes a wrench, what is the same for all rotors multiplies the wrench.
"""

from __future__ import annotations

import numpy as np

from infotraj.dynamics.actuators import thrusts
from infotraj.effects.along import Along
from infotraj.effects.base import Declared, Effect, Parameter
from infotraj.errors import InputError, problem
from infotraj.flight import Flight
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle


class ThrustScale(Effect):
    """Every thrust times `factor`: a wrong thrust coefficient, air density, worn rotors."""

    name = "thrust_scale"
    place = "thrust"
    parameters = (Parameter("factor", "-", 0.1, (0.5, 2.0), absent=1.0, meaning="true thrust per modelled thrust"),)
    factor: float
    source = "T = k_F w^2; Leishman, Principles of Helicopter Aerodynamics, 2.4 (thrust coefficient)"
    like_commands = True
    day = 0.2  # 2 %: air of 5 degrees or 20 hPa more

    @classmethod
    def whole(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 1.0

    def thrust_factor(self, along: Along) -> float:
        return self.factor


class RotorEffectiveness(Effect):
    """One rotor's thrust times `factor`: a chipped blade, a weak motor. May stand more than once."""

    name = "rotor_effectiveness"
    place = "thrust"
    parameters = (
        Parameter("rotor", "-", 1, (0, 1000), index=True, meaning="its place in the vehicle file's list, from 0"),
        Parameter("factor", "-", 0.15, (0.0, 1.5), absent=1.0, meaning="true thrust per modelled thrust"),
    )
    rotor: int
    factor: float
    source = "loss of control effectiveness; Zhang and Jiang, Annual Reviews in Control 32 (2008)"
    repeatable = True
    declared = Declared("rotors", 1 / 15, "rotor_{rotor}.thrust, factor", 1.0)  # 1 % of a rotor's thrust

    @classmethod
    def whole(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 1.0

    @classmethod
    def in_the_file(cls, vehicle: Vehicle, place: int, rotor: int) -> tuple[str, float, float]:
        own = vehicle.rotors[rotor]
        k = own.thrust_coefficient if own.input == "speed" else None
        return (f"rotor_{rotor}.thrust_coefficient", k, k) if k else super().in_the_file(vehicle, place, rotor)

    def check(self, vehicle: Vehicle) -> None:
        super().check(vehicle)
        if self.rotor >= len(vehicle.rotors):
            there = f"0 to {len(vehicle.rotors) - 1}, the rotors of {vehicle.name}"
            expected = there if vehicle.rotors else f"a vehicle with rotors, which {vehicle.name} has not"
            raise InputError(problem(f"{self.name}: rotor {self.rotor}", expected, "Correct it."))

    def thrust_factor(self, along: Along) -> Array:
        factor = np.ones(len(along.vehicle.rotors))
        factor[self.rotor] = self.factor
        return factor


class CoaxialLoss(Effect):
    """Lower rotors of coaxial pairs lose this fraction of their thrust, in the wake of the upper ones."""

    name = "coaxial_loss"
    place = "thrust"
    parameters = (Parameter("fraction", "-", 0.15, (0.0, 0.6), meaning="share of a lower rotor's thrust that is lost"),)
    fraction: float
    built = True
    needs = needs_to_act = ("rotors",)
    source = "Leishman, Principles of Helicopter Aerodynamics, 2.14"
    hidden_when = "the vehicle has no coaxial rotors"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        lower = any(r.coaxial == "lower" for r in vehicle.rotors)
        return None if lower else "the vehicle file marks no rotor `coaxial: lower`"

    def thrust_factor(self, along: Along) -> Array:
        return np.array([1.0 - self.fraction * (r.coaxial == "lower") for r in along.vehicle.rotors])


class MomentScale(Effect):
    """Every rotor's reaction torque times `factor`: Q = factor x moment_constant x T.

    Of a vehicle that takes a wrench and has a `thrust_axis`, the commanded torque about it.
    """

    name = "moment_scale"
    place = "thrust"
    parameters = (Parameter("factor", "-", 0.3, (0.0, 3.0), absent=1.0, meaning="true torque per modelled torque"),)
    factor: float
    needs = ("inertia", "rate", "reaction torque")
    needs_to_act = ("reaction torque",)
    source = "Leishman, Principles of Helicopter Aerodynamics, 2.4 (torque coefficient)"
    hidden_when = "coaxial pairs turn at equal speed: their reaction torques cancel"
    like_commands = True
    declared = Declared("moment", 1 / 15, "{moment}, factor", 1.0)  # 2 %

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        if vehicle.inputs == "wrench":
            return None
        if not any(r.moment_constant for r in vehicle.rotors):
            return "the vehicle file gives every rotor a moment_constant of 0"
        return cancelling(vehicle, flight, "reaction torques")

    @classmethod
    def whole(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 1.0

    def reaction_factor(self, along: Along) -> float:
        return self.factor


class AxialInflow(Effect):
    """A rotor that climbs along its axis loses thrust: T - k w (v_r . d), v_r its velocity through the air.

    First order in the inflow ratio: Leishman, Principles of Helicopter Aerodynamics, 3.3 (blade element); as `k_z` in
    Svacha et al., "Improving quadrotor trajectory tracking by compensating for aerodynamic effects" (2017), and in
    rotorpy.
    """

    name = "axial_inflow"
    place = "thrust"
    parameters = (Parameter("k", "N s^2/(m rad)", 2e-4, (0.0, 5e-3)),)
    k: float
    built = True
    needs = ("velocity", "rate", "rotor speed")
    needs_to_act = needs
    damps_turns = True
    source = "Svacha et al. (2017); rotorpy; Leishman 3.3"

    @classmethod
    def scale(cls, vehicle: Vehicle, parameter: Parameter) -> float:
        return 0.4 * mass_per_speed(vehicle)

    def thrust_loss(self, along: Along) -> Array:
        return self.k * along.speed * along.axial_velocity


class GroundEffect(Effect):
    """Near the ground a rotor's thrust grows: T (1 + k (R / h)^2), h the rotor's height above z = 0.

    The first term of Cheeseman and Bennett, "The effect of the ground on a helicopter rotor in forward flight" (ARC
    R&M 3021, 1955), T / T_free = 1 / (1 - (R / 4h)^2), for which k = 1/16. That formula has a pole at h = R / 4:
    heights below it count as R / 4.
    """

    name = "ground_effect"
    place = "thrust"
    parameters = (Parameter("k", "-", 0.15, (0.0, 3.0)),)
    k: float
    built = True
    needs = ("height", "radius")
    needs_to_act = needs
    source = "Cheeseman and Bennett (1955)"
    hidden_when = "the flight never comes near z = 0"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        lowest = float(np.nanmin(flight.get("pz")))
        radius = max(r.radius or 0.0 for r in vehicle.rotors)
        if lowest > 20.0 * radius:
            return f"the flight stays {lowest:.2g} m above z = 0, {lowest / radius:.0f} rotor radii"
        return None

    def thrust_factor(self, along: Along) -> Array:
        radius = np.array([r.radius for r in along.vehicle.rotors])
        return 1.0 + self.k * (radius / np.maximum(along.rotor_height, radius / 4)) ** 2


class BatterySag(Effect):
    """Thrust falls with the battery: T (1 - rate t), or T (V / V_nominal)^exponent where the voltage is recorded.

    t counts from the flight's first row. A motor without speed control turns in proportion to the voltage, so that the
    exponent is about 2 (thrust goes with the square of the speed); less where the controller compensates.
    """

    name = "battery_sag"
    place = "thrust"
    parameters = (
        Parameter("rate", "1/s", 0.003, (-0.02, 0.05), optional=True, meaning="share of the thrust lost a second"),
        Parameter("exponent", "-", 1.0, (-1.0, 6.0), optional=True, meaning="of voltage over nominal_voltage"),
    )
    rate: float
    exponent: float
    source = "DC motor at fixed duty cycle: speed in proportion to the voltage; T = k_F w^2"
    day = 0.2  # of the rate or the exponent: one cell is older or colder than another

    @classmethod
    def form(cls, vehicle: Vehicle, flight: Flight) -> tuple[Parameter, ...]:
        voltage = vehicle.nominal_voltage is not None and flight.has("battery")
        return cls.parameters[1:] if voltage else cls.parameters[:1]

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        if cls.form(vehicle, flight)[0].name == "exponent":
            volts = flight.get("battery")
            if np.nanmax(volts) - np.nanmin(volts) < 1e-3 * (vehicle.nominal_voltage or 0.0):
                return "the recorded voltage does not change"
        return None

    def check(self, vehicle: Vehicle) -> None:
        super().check(vehicle)
        if self.rate and self.exponent:
            raise InputError(problem(f"{self.name}: rate and exponent", "one of them", "Remove the other."))
        if self.exponent and vehicle.nominal_voltage is None:
            raise InputError(
                problem(f"{self.name}: an exponent", f"`nominal_voltage` in {vehicle.name}'s file", "Add it.")
            )

    def missing(self, vehicle: Vehicle, flight: Flight) -> str | None:
        if self.exponent and not flight.has("battery"):
            return "the flight has no voltage (battery)"
        return super().missing(vehicle, flight)

    def thrust_factor(self, along: Along) -> Array:
        battery, nominal = along.motion.battery, along.vehicle.nominal_voltage
        if self.exponent and battery is not None and nominal is not None:  # see `check` and `missing`
            ratio = np.maximum(battery / nominal, 1e-3)
            return (ratio**self.exponent)[:, None]
        return (1.0 - self.rate * along.time)[:, None]


class RotorInterference(Effect):
    """The wake of a tilted neighbour lowers the thrust of an arm's rotors.

    Arms are numbered by azimuth, counter-clockwise from above. Arm i loses the fraction k (max(0, sin a_{i-1})^2
    A_{i-1} + max(0, -sin a_{i+1})^2 A_{i+1}) / mean(A), A being the arms' thrusts k_F w^2, a their tilts: a positive
    tilt blows towards the next arm. The catalogue's own form of what Bodie et al. (2019) report for tilted rotors.
    """

    name = "rotor_interference"
    place = "thrust"
    parameters = (Parameter("k", "-", 0.06, (0.0, 1.0)),)
    k: float
    built = True
    needs = ("tilts",)
    needs_to_act = needs
    source = "the catalogue; reported for tilted rotors by Bodie et al., omnidirectional aerial manipulation (2019)"
    hidden_when = "no arm tilts"

    @classmethod
    def hidden(cls, vehicle: Vehicle, flight: Flight) -> str | None:
        if len(arms(vehicle)) < 2:
            return "the vehicle has fewer than two arms with rotors that tilt"
        return None

    def thrust_factor(self, along: Along) -> Array:
        order = arms(along.vehicle)
        of_rotor = np.array([-1 if r.tilt is None else r.tilt for r in along.vehicle.rotors])
        member = (of_rotor[None, :] == order[:, None]).astype(float)
        push = along.nominal_thrust @ member.T
        swing = np.sin(along.tilt[:, order])
        ahead, behind = np.maximum(swing, 0.0) ** 2 * push, np.maximum(-swing, 0.0) ** 2 * push
        mean = push.mean(axis=1, keepdims=True)
        loss = (np.roll(ahead, 1, axis=1) + np.roll(behind, -1, axis=1)) / np.where(mean > 0, mean, 1.0)
        return 1.0 - self.k * loss @ member


def arms(vehicle: Vehicle) -> Array:
    """Tilts that turn rotors, sorted by azimuth of their axes, counter-clockwise from above: (arms,) indices."""
    used = sorted({r.tilt for r in vehicle.rotors if r.tilt is not None})
    azimuth = [np.arctan2(vehicle.tilts[i].axis[1], vehicle.tilts[i].axis[0]) for i in used]
    return np.array(used, dtype=int)[np.argsort(azimuth)]


def mass_per_speed(vehicle: Vehicle) -> float:
    """Mass over the sum of the rotors' speeds in hover (kg s/rad): what coefficients per rotor speed scale with."""
    k_f = [r.thrust_coefficient for r in vehicle.rotors]
    if vehicle.mass is None or not k_f or any(k is None for k in k_f):
        return 5e-4
    return vehicle.mass / float(np.sum(np.sqrt(hover_thrust(vehicle) / np.array(k_f))))


def hover_thrust(vehicle: Vehicle) -> float:
    """Thrust (N) of a rotor in hover: the weight by the vehicle file, shared evenly."""
    return vehicle.known_mass() * vehicle.gravity / len(vehicle.rotors)


def cancelling(vehicle: Vehicle, flight: Flight, what: str) -> str | None:
    """The reason where rotors on one axis always turn so that `what` of theirs cancels, else None.

    what: "reaction torques", "angular momenta" or "hub moments" (of a velocity through the air that all have). Asked of
    commands or measured values, rotor by rotor; rotors belong together that share tilt and axis.
    """
    for prefix in ("cmd_rotor_", "rotor_"):
        columns = [f"{prefix}{i}" for i in range(len(vehicle.rotors))]
        if flight.has(*columns):
            break
    else:
        return None
    turn = _torques if what == "reaction torques" else _speeds
    sizes = turn(vehicle, flight.get(*columns))
    groups: dict[tuple, list[int]] = {}
    for i, rotor in enumerate(vehicle.rotors):
        groups.setdefault((rotor.tilt, tuple(np.round(rotor.axis, 6))), []).append(i)
    net, total = 0.0, 0.0
    for members in groups.values():
        each = sizes[:, members]
        net = max(net, float(np.nanmax(np.abs(each @ [vehicle.rotors[i].spin for i in members]))))
        total = max(total, float(np.nanmax(each.sum(axis=1))))
    if net <= 1e-3 * total:
        return f"rotors on one axis turn at equal speed in opposite senses: their {what} cancel"
    return None


def _torques(vehicle: Vehicle, inputs: Array) -> Array:
    """Sizes (N, rotors) of the rotors' reaction torques, N m."""
    return np.abs(thrusts(vehicle, inputs)) * [r.moment_constant for r in vehicle.rotors]


def _speeds(vehicle: Vehicle, inputs: Array) -> Array:
    """Speeds (N, rotors) of the rotors, rad/s; of one whose thrust_coefficient is not known in units of its own."""
    thrust, speed = np.maximum(thrusts(vehicle, inputs), 0.0), [r.input == "speed" for r in vehicle.rotors]
    return np.where(speed, np.abs(inputs), np.sqrt(thrust / [r.thrust_coefficient or 1.0 for r in vehicle.rotors]))
