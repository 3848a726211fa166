"""What a vehicle file says of itself, before any flight: how it hovers, and what no vehicle can be."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from infotraj.describing.guesses import thrust_coefficient_of_propeller
from infotraj.vehicle import Vehicle

FASTEST_TIP = 250.0  # m/s: nearer to the speed of sound no propeller of a multirotor hovers
RPM = np.pi / 30.0  # rad/s
SLOWEST_TIP = 10.0  # m/s
TORQUES = (0.01, 1.0)  # moment constant over a propeller's diameter: 0.07 to 0.15 in the shipped files
LAGS = (0.001, 1.0)  # s, of a rotor
_FACTOR = 5.0  # between a propeller's thrust and that of others of its diameter
_ONE_PLACE = 0.02  # of the longest arm


@dataclass(frozen=True)
class Said:
    """A sentence about the file, and whether it may be so."""

    sentence: str
    good: bool


def alone(vehicle: Vehicle) -> list[Said]:
    """What can be told of the file by itself, good and not."""
    body = [Said(vehicle.inertia.doubt, False)] if vehicle.inertia is not None and vehicle.inertia.doubt else []
    if not vehicle.rotors:
        return body
    return [
        *body,
        *_hover(vehicle),
        *_lift(vehicle),
        *_thrusts(vehicle),
        *_torques(vehicle),
        *_places(vehicle),
        *_spins(vehicle),
    ]


def _hover(vehicle: Vehicle) -> list[Said]:
    turning = [r for r in vehicle.rotors if r.input == "speed" and r.thrust_coefficient]
    up = sum((r.thrust_coefficient or 0.0) * abs(r.axis[2]) for r in turning)
    if vehicle.mass is None or vehicle.tilts or len(turning) < len(vehicle.rotors) or up <= 0.0:
        return []
    speed = float(np.sqrt(vehicle.mass * vehicle.gravity / up))
    said = f"it hovers with all rotors at {speed:.4g} rad/s, {speed / RPM:.4g} rpm"
    radii = [r.radius for r in turning if r.radius]
    if not radii:
        return [Said(said, True)]
    tip = speed * max(radii)
    good = SLOWEST_TIP < tip < FASTEST_TIP
    doubt = "" if good else f": tips of {SLOWEST_TIP:g} to {FASTEST_TIP:g} m/s are usual; mass or thrust_coefficient?"
    return [Said(f"{said}, tips at {tip:.3g} m/s{doubt}", good)]


def _lift(vehicle: Vehicle) -> list[Said]:
    """Whether the greatest inputs carry the mass, where the file has them."""
    if vehicle.mass is None or vehicle.tilts:
        return []
    up = 0.0
    for r in vehicle.rotors:
        if r.input == "throttle" and r.thrust_polynomial is not None:
            greatest = sum(r.thrust_polynomial)
        elif r.max_speed is not None and r.thrust_coefficient is not None:
            greatest = r.thrust_coefficient * r.max_speed**2
        else:
            return []
        up += greatest * abs(r.axis[2])
    weight = vehicle.mass * vehicle.gravity
    if up > weight:
        return []
    which = "max_speed" if vehicle.rotors[0].max_speed is not None else "throttle 1"
    return [Said(f"it cannot hover: at {which} its rotors lift {up:.4g} N, and it weighs {weight:.4g} N", False)]


def _thrusts(vehicle: Vehicle) -> list[Said]:
    found = []
    for r in vehicle.rotors:
        if r.input != "speed" or not r.thrust_coefficient or not r.radius:
            continue
        usual = thrust_coefficient_of_propeller(2 * r.radius).value
        if not 1 / _FACTOR < r.thrust_coefficient / usual < _FACTOR:
            said = f"{r.name}: thrust_coefficient {r.thrust_coefficient:.3g}; propellers of {2 * r.radius:.3g} m have"
            found.append(Said(f"{said} about {usual:.2g} N s^2/rad^2: the unit of the speed, or the radius?", False))
    return found


def _torques(vehicle: Vehicle) -> list[Said]:
    found = []
    for r in vehicle.rotors:
        if r.radius and not TORQUES[0] < r.moment_constant / (2 * r.radius) < TORQUES[1]:
            usual = f"{TORQUES[0]:g} to {TORQUES[1]:g} diameters are usual"
            found.append(Said(f"{r.name}: moment_constant {r.moment_constant:g} m: {usual}", False))
        if r.time_constant > LAGS[1]:
            said = f"{r.name}: time_constant {r.time_constant:g} s: at most {LAGS[1]:g} s is usual; is it in ms?"
            found.append(Said(said, False))
    return found


def _places(vehicle: Vehicle) -> list[Said]:
    reach = max(float(np.linalg.norm(r.position)) for r in vehicle.rotors)
    return [
        Said(f"{one.name} and {other.name} stand in one place", False)
        for one, other in combinations(vehicle.rotors, 2)
        if not (one.coaxial or other.coaxial or one.tilt is not None)
        and np.linalg.norm(np.subtract(one.position, other.position)) < _ONE_PLACE * reach
    ]


def _spins(vehicle: Vehicle) -> list[Said]:
    total = sum(r.spin for r in vehicle.rotors)
    if abs(total) <= len(vehicle.rotors) % 2:
        return []
    one = sum(r.spin > 0 for r in vehicle.rotors)
    other = len(vehicle.rotors) - one
    return [Said(f"{one} rotors turn counter-clockwise and {other} clockwise: as many of each are usual", False)]
