"""The numbers of fitted effects and of the vehicle file, with their standard errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.linear.candidates import places, slopes
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.select.search import Fit
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

ORDINARY = 3.0  # standard deviations of this file's own errors: further off, a number is a finding
THRUST_OVER_MASS = "thrust of all rotors over mass, factor"
_SEEN = 3.0  # standard errors by which a file number must be off to be told
_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class FileNumber:
    """What one number of the vehicle file should say. ordinary: within what this file's numbers are off by."""

    name: str
    declared: float
    value: float
    standard_error: float
    ordinary: bool


def values_of(m: Member) -> dict[str, Any]:
    """What is fixed and what is fitted of a member, other forms of the effect left out."""
    wanted = {*dict(m.candidate.fixed), *(p.name for p in m.candidate.form)}
    return {k: v for k, v in m.effect.values.items() if k in wanted}


def fitted_numbers(made: Fit) -> list[dict[str, Any]]:
    """Standard errors of every member of a fit by parameter."""
    vehicle = made.linear.observation.vehicle
    wider, covariance = overdispersion(made)
    deviation = np.sqrt(np.diag(covariance))
    if made.linear.observation.healthy is not None:
        deviation = np.sqrt(wider) * made.changes[2]
    out = []
    for m in made.members:
        at = m.places(vehicle)
        values, slope = np.zeros(len(at)), slopes(m.effect, at)
        for i, c in enumerate(made.linear.columns):
            if c.candidate.label == m.candidate.label and deviation[i] > 0:
                values[c.place] = deviation[i] * abs(c.scale) * slope[c.place]
        out.append(by_parameter(m, values))
    return out


def by_parameter(m: Member, values: Array) -> dict[str, Any]:
    """Numbers of a member by parameter, a list where the parameter is one."""
    out, place = {}, 0
    for p in m.candidate.form:
        size = np.size(getattr(m.effect, p.name))
        part = [float(v) for v in values[place : place + size]]
        out[p.name] = part[0] if p.size == 1 else part
        place += size
    return out


def file_numbers(made: Fit) -> tuple[FileNumber, ...]:
    """The numbers of the vehicle file, its clocks and frames, that these flights show to be off."""
    linear = made.linear
    if linear.observation.healthy is not None:
        return ()
    vehicle = linear.observation.vehicle
    spike = linear.spike(made.scales)
    covariance = overdispersion(made)[1]
    deviation = np.sqrt(np.diag(covariance))
    labels = set(made.labels)
    out = _thrust_over_mass(made, spike, covariance)
    for i, c in enumerate(linear.columns):
        if spike[i] <= 0 or c.candidate.label in labels or deviation[i] <= 0:
            continue
        theta = made.solution.theta[i]
        if abs(theta) < _SEEN * deviation[i]:
            continue
        name, declared, per = _in_the_file(c.candidate.name, dict(c.candidate.fixed), c.place, vehicle)
        at = places(c.candidate, vehicle)[c.place]
        moved = at.value(at.absent + theta * c.scale)
        error = abs(deviation[i] * per * c.scale) * at.slope(moved)
        ordinary = abs(theta) < ORDINARY * spike[i]
        out.append(FileNumber(name, declared, declared + per * (moved - at.absent), float(error), bool(ordinary)))
    return tuple(out)


def _thrust_over_mass(made: Fit, spike: Array, covariance: Array) -> list[FileNumber]:
    """By which factor the thrust of all rotors over the mass is off, where flights show it; none where a name says it.

    Accelerations tell the ratio, and hardly ever which of the two is off: each alone may be within its error.
    """
    linear = made.linear
    vehicle = linear.observation.vehicle
    labels = set(made.labels)
    if {x.split()[0] for x in labels} & {"mass_offset", "thrust_scale"} or not vehicle.mass:
        return []
    weight = np.zeros(len(linear.columns))
    for i, c in enumerate(linear.columns):
        name = c.candidate.name
        if c.candidate.label in labels:
            continue
        if name == "rotor_effectiveness" and spike[i] > 0:
            weight[i] = c.scale / len(vehicle.rotors)
        elif name == "mass_offset" and spike[i] > 0:
            weight[i] = -c.scale / vehicle.mass
    # Coordinates are logarithms: a ratio is a sum.
    total, error = float(weight @ made.solution.theta), float(np.sqrt(weight @ covariance @ weight))
    if error <= 0 or abs(total) < _SEEN * error:
        return []
    ordinary = abs(total) < ORDINARY * float(np.linalg.norm(weight * spike))
    factor = float(np.exp(total))
    return [FileNumber(THRUST_OVER_MASS, 1.0, factor, error * factor, ordinary)]


def _in_the_file(effect: str, fixed: dict[str, int], place: int, vehicle: Vehicle) -> tuple[str, float, float]:
    """Name of a file number, what is declared, and how much it changes a unit of the effect's parameter."""
    rotor = fixed.get("rotor", 0)
    axis = _AXES[place] if place < 3 else str(place)
    if effect == "rotor_effectiveness":
        k = vehicle.rotors[rotor].thrust_coefficient
        return (f"rotor_{rotor}.thrust_coefficient", k, k) if k else (f"rotor_{rotor}.thrust, factor", 1.0, 1.0)
    if effect == "mass_offset":
        return "mass", float(vehicle.mass or 0.0), 1.0
    if effect == "inertia_error":
        moments = np.diag(vehicle.inertia.matrix()) if vehicle.inertia is not None else np.zeros(3)
        return f"inertia.{axis}{axis}", float(moments[place]), 1.0
    if effect == "com_offset":
        return f"center_of_mass.{axis}", float(vehicle.center_of_mass[place]), 1.0
    if effect == "rotor_torque":
        # A thrust along z that acts further along y turns about x.
        if place == 2:
            r = vehicle.rotors[rotor]
            return f"rotor_{rotor}.moment_constant", float(r.moment_constant), -float(r.spin)
        other, sign = (1, 1.0) if place == 0 else (0, -1.0)
        return f"rotor_{rotor}.position.{_AXES[other]}", float(vehicle.rotors[rotor].position[other]), sign
    words = {
        "moment_scale": ("moment_constant of all rotors, factor", 1.0),
        "rotor_lag": ("time_constant of the rotors, more by", 0.0),
        "rotor_place": (f"middle of the rotors, further along {axis} by", 0.0),
        "servo_lag": ("time_constant of the tilts, more by", 0.0),
        "actuation_delay": ("commands, later by", 0.0),
        "time_offset": ("clock of the IMU, later by", 0.0),
        "sensor_lag": ("filters of the sensors, later by", 0.0),
        "servo_bias": (f"tilt_{place}, offset", 0.0),
        "steady_force": (f"level of the world frame or bias of the accelerometer, as a force along {axis}", 0.0),
        "imu_misalignment": (f"frame of the IMU, turned about {axis} by", 0.0),
    }
    name, declared = words.get(effect, (f"{effect}.{axis}", 0.0))
    return name, declared, 1.0
