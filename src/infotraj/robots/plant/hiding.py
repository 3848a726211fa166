"""Builds a plant's truth from the effects that it is to hide, by their public names and parameters.

The catalogue says what a name means; how it comes about here is the plant's own. `RICHER` names physics beyond the
catalogue, of which the catalogue has a nearest name; `UNLISTED` what it has no name for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from pydantic import BaseModel

from infotraj.errors import InputError, problem
from infotraj.robots.plant.hidden import (
    FlexibleArm,
    Gusts,
    Hysteresis,
    Load,
    Pack,
    Sag,
    Slosh,
    Turbulence,
    Wall,
)  # fmt: skip
from infotraj.robots.plant.truth import Blades, Interference, Lag, SecondOrder, Truth
from infotraj.vehicle import Vehicle

Values = Mapping[str, Any]
Hide = Callable[[Truth, Vehicle, Values], Truth]


def hide(vehicle: Vehicle, effects: Sequence[tuple[str, Values]], name: str = "hidden") -> Truth:
    """The vehicle's ideal plant with these effects in it. InputError for a name that no plant can carry."""
    truth = exact(Truth.ideal(vehicle)).model_copy(update={"name": name})
    for effect, values in effects:
        make = {**CATALOGUE, **RICHER, **UNLISTED}.get(effect)
        if make is None:
            raise InputError(problem(f"hidden effect {effect}", "one of the plant's", "Correct the name."))
        truth = make(truth, vehicle, values)
    return truth


def exact(truth: Truth) -> Truth:
    """The same plant with servos that follow a first-order lag as closely as MuJoCo can in steps of 1 ms.

    Its step is explicit in the position, which makes a lag shorter by half a step; and the servo's own inertia is made
    lighter. Parameters are recovered to a thousandth here, where a lag that is 0.5 ms off would count.
    """
    if truth.servos is None:
        return truth
    lag = truth.servos.dynamics
    assert isinstance(lag, Lag)  # as an ideal plant's is
    return _with(
        truth, "servos",
        dynamics=lag.model_copy(update={"time_constant": lag.time_constant + 0.5e-3, "fast_time_constant": 1e-4}),
    )  # fmt: skip


def clutter(truth: Truth, vehicle: Vehicle, sizes: Values, rng: np.random.Generator) -> Truth:
    """The truth with every rotor a little different, inertia and centre of mass a little off, and turbulence.

    sizes: `rotors` (share, standard deviation), `inertia` (share), `center_of_mass` (m), `force` (share of the weight)
    and `torque` (share of the weight times the rotors' mean distance), standard deviations of turbulence,
    `correlation_time` (s).
    """
    n = len(vehicle.rotors)
    factor = np.array(truth.rotors.thrust_factor) * (1.0 + sizes["rotors"] * rng.standard_normal(n))
    about = truth.inertia.matrix()
    turned = 1.0 + sizes["inertia"] * rng.choice([-1.0, 1.0], 3)
    off = rng.standard_normal(3)
    place = np.array(truth.center_of_mass) + sizes["center_of_mass"] * off / np.linalg.norm(off)
    weight = vehicle.known_mass() * vehicle.gravity
    reach = float(np.mean([np.linalg.norm(r.position) for r in vehicle.rotors]))
    air = Turbulence(
        force=sizes["force"] * weight,
        torque=sizes["torque"] * weight * reach,
        correlation_time=sizes["correlation_time"],
    )
    truth = _with(truth, "rotors", thrust_factor=tuple(factor.tolist()))
    truth = _inertia(truth, np.diag(about) * turned)
    truth = truth.model_copy(update={"center_of_mass": tuple(place.tolist())})
    return _disturb(truth, turbulence=air)


def gusty(truth: Truth, vehicle: Vehicle, sizes: Values, rng: np.random.Generator) -> Truth:
    """The truth in gusts from any side. sizes: `speed` (m/s), `height` (m), `drag` (1/s, times the mass: N s/m)."""
    heading = float(rng.uniform(-np.pi, np.pi))
    drag = sizes["drag"] * vehicle.mass
    return _disturb(truth, gusts=Gusts(speed=sizes["speed"], height=sizes["height"], heading=heading, drag=drag))


def _with(truth: Truth, section: str, **values: Any) -> Truth:
    return truth.model_copy(update={section: getattr(truth, section).model_copy(update=values)})


def _hidden(truth: Truth, **values: Any) -> Truth:
    return _with(truth, "hidden", **values)


def _disturb(truth: Truth, **values: Any) -> Truth:
    return _hidden(truth, disturbance=truth.hidden.disturbance.model_copy(update=values))


def _imu(truth: Truth, **values: Any) -> Truth:
    return _hidden(truth, imu=truth.hidden.imu.model_copy(update=values))


def _of(section: str, field: str, key: str, make: Callable[[Any], Any] = lambda value: value) -> Hide:
    """Sets one field of a section to one parameter."""
    return lambda truth, vehicle, values: _with(truth, section, **{field: make(values[key])})


def _triple(values: Any) -> tuple[float, ...]:
    return tuple(float(v) for v in values)


def _inertia(truth: Truth, diagonal: Any) -> Truth:
    xx, yy, zz = (float(v) for v in diagonal)
    return truth.model_copy(update={"inertia": truth.inertia.model_copy(update={"xx": xx, "yy": yy, "zz": zz})})


def _inertia_error(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    change = [values.get(k, 0.0) for k in ("dxx", "dyy", "dzz")]
    return _inertia(truth, np.diag(truth.inertia.matrix()) + change)


def _mass(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    return truth.model_copy(update={"mass": truth.mass + values["dm"]})


def _center(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    return truth.model_copy(update={"center_of_mass": tuple((np.array(truth.center_of_mass) + values["r"]).tolist())})


def _thrust_scale(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    return _with(truth, "rotors", thrust_factor=tuple(f * values["factor"] for f in truth.rotors.thrust_factor))


def _one_rotor(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    factor = list(truth.rotors.thrust_factor)
    factor[int(values["rotor"])] *= values["factor"]
    return _with(truth, "rotors", thrust_factor=tuple(factor))


def _moment_scale(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    return _with(truth, "rotors", moment_factor=tuple(f * values["factor"] for f in truth.rotors.moment_factor))


def _rotor_lag(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    extra, rotors = values["extra_time_constant"], truth.rotors
    return _with(
        truth, "rotors", rise_time_constant=rotors.rise_time_constant + extra,
        fall_time_constant=rotors.fall_time_constant + extra,
    )  # fmt: skip


def _servo_lag(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    servo = truth.tilting()[0].dynamics
    if not isinstance(servo, Lag):
        raise InputError(problem("servo_lag beside second-order servos", "one of them", "Drop one."))
    return _with(
        truth,
        "servos",
        dynamics=servo.model_copy(update={"time_constant": servo.time_constant + values["extra_time_constant"]}),
    )


def _battery(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    if "rate" in values:
        return _hidden(truth, supply=Sag(rate=values["rate"]))
    return _hidden(truth, supply=pack(vehicle, exponent=values["exponent"]))


def pack(vehicle: Vehicle, **values: Any) -> Pack:
    """A battery sized to the vehicle: hovering draws 2 % of its voltage through its resistance, and 6 % more in 16 s.

    Assumed; a worn pack near its end, so that a short flight shows what a long one would.
    """
    if vehicle.nominal_voltage is None:
        raise InputError(problem(f"{vehicle.name}: no nominal_voltage", "`nominal_voltage` in V", "Add it."))
    volts = vehicle.nominal_voltage
    power = 180.0 * vehicle.known_mass()  # W in hover: 180 W/kg, usual for rotors of this loading
    k = [r.known_thrust_coefficient() for r in vehicle.rotors]
    hover = np.sqrt(vehicle.known_mass() * vehicle.gravity / np.sum(k))
    current = power / volts
    known = {
        "nominal": volts,
        "full": 1.02 * volts,
        "slope": 0.06 * volts / (current * 16.0),
        "resistance": 0.02 * volts / current,
        "power_coefficient": power / (len(k) * hover**3),
        "log_noise": 1e-3 * volts,
    }
    return Pack(**{**known, **values})


def _real_pack(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    return _hidden(truth, supply=pack(vehicle, **values))


def _blades(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
    """Stiff blades (`Blades`), and beside them `body_drag` (N s^2/m^2, an axis) and `flapping` (s/m)."""
    blades = {k: v for k, v in values.items() if k not in ("body_drag", "flapping")}
    truth = _with(truth, "air", quadratic_drag=_triple(values["body_drag"]), flapping=values["flapping"])
    return truth.model_copy(update={"blades": Blades(**blades)})


def _spread(key: str) -> Hide:
    """One number for every tilt."""

    def make(truth: Truth, vehicle: Vehicle, values: Values) -> Truth:
        if key == "half_width":
            return _hidden(truth, backlash=float(values[key]))
        return _with(truth, "servos", zero_error=_triple(values[key]))

    return make


def _section(kind: type[BaseModel], field: str) -> Hide:
    return lambda truth, vehicle, values: _hidden(truth, **{field: kind(**values)})


CATALOGUE: dict[str, Hide] = {
    "mass_offset": _mass,
    "inertia_error": _inertia_error,
    "com_offset": _center,
    "thrust_scale": _thrust_scale,
    "rotor_effectiveness": _one_rotor,
    "coaxial_loss": _of("air", "coaxial_loss", "fraction"),
    "moment_scale": _moment_scale,
    "axial_inflow": _of("air", "axial_inflow", "k"),
    "ground_effect": _of("air", "ground_effect", "k"),
    "battery_sag": _battery,
    "rotor_interference": _of("air", "tilt_interference", "k"),
    "rotor_lag": _rotor_lag,
    "servo_lag": _servo_lag,
    "servo_rate_limit": _of("servos", "max_rate", "max_rate"),
    "servo_backlash": _spread("half_width"),
    "servo_bias": _spread("bias"),
    "actuation_delay": lambda truth, vehicle, values: _hidden(truth, command_delay=values["delay"]),
    "rotor_drag": _of("air", "rotor_drag", "k"),
    "linear_drag": _of("air", "linear_drag", "d", _triple),
    "quadratic_drag": _of("air", "quadratic_drag", "d", _triple),
    "angular_damping": _of("air", "angular_damping", "d", _triple),
    "gyroscopic": _of("rotors", "inertia", "rotor_inertia"),
    "steady_force": lambda truth, vehicle, values: _disturb(truth, force=_triple(values["f"])),
    "steady_torque": lambda truth, vehicle, values: _disturb(truth, torque=_triple(values["t"])),
    "suspended_load": _section(Load, "load"),
    "gyro_bias": lambda truth, vehicle, values: _imu(truth, gyro_bias=_triple(values["b"])),
    "accelerometer_bias": lambda truth, vehicle, values: _imu(truth, accelerometer_bias=_triple(values["b"])),
    "imu_misalignment": lambda truth, vehicle, values: _imu(truth, rotvec=_triple(values["rotvec"])),
    "time_offset": lambda truth, vehicle, values: _imu(truth, delay=values["dt"]),
    "wind": _of("air", "wind", "v", _triple),
    "pressure_centre": _of("air", "pressure_centre", "r", _triple),
    "hub_moment": _of("air", "hub_moment", "k"),
    "translational_lift": _of("air", "translational_lift", "k"),
    "thrust_exponent": _of("rotors", "thrust_exponent", "n"),
    "sensor_lag": lambda truth, vehicle, values: _imu(truth, lag=values["time_constant"]),
}

RICHER: dict[str, Hide] = {
    "second_order_servos": lambda truth, vehicle, values: _with(truth, "servos", dynamics=SecondOrder(**values)),
    "uneven_rotor_lags": lambda truth, vehicle, values: _with(
        truth, "rotors", rise_time_constant=values["rise"], fall_time_constant=values["fall"]
    ),
    "wakes": lambda truth, vehicle, values: _with(truth, "air", interference=Interference(**values)),
    "blade_flapping": lambda truth, vehicle, values: _with(truth, "air", **values),
    "real_battery": _real_pack,
    "blade_elements": _blades,
}

UNLISTED: dict[str, Hide] = {
    "slosh": _section(Slosh, "slosh"),
    "thrust_hysteresis": _section(Hysteresis, "hysteresis"),
    "flexible_arm": _section(FlexibleArm, "flexible_arm"),
    "wall_wake": lambda truth, vehicle, values: _disturb(truth, wall=Wall(**values)),
    "magnetic_torque": lambda truth, vehicle, values: _disturb(truth, magnetic=_triple(values["torque"])),
}
