"""Bodies beside base and arms: a load on a cable, a mass that sloshes, an arm that bends. As MJCF."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import numpy as np

from infotraj.robots.plant.truth import Truth
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

# A body needs an inertia: as a point mass has none, one of a thousandth of its mass times (1 cm)^2.
POINT = 1e-7
# 1/s, drag over mass: stops a hanging load within a second, while a plant waits for its flight to begin.
BRAKE = 4.0


def attach(base: ET.Element, vehicle: Vehicle, truth: Truth) -> dict[tuple[str, int], ET.Element]:
    """Adds the attachments to `base`; gives the body that carries tilt i or rotor i where it is not the base."""
    hidden = truth.hidden
    if hidden.load is not None:
        body = ET.SubElement(base, "body", name="load")
        ET.SubElement(body, "joint", name="cable", type="ball")
        _point(body, hidden.load.mass, np.array([0.0, 0.0, -hidden.load.length]))
    if hidden.slosh is not None:
        s = hidden.slosh
        body = ET.SubElement(base, "body", name="slosh", pos=_text(*s.place))
        omega = 2.0 * math.pi * s.frequency
        for name, axis in (("slosh_x", "1 0 0"), ("slosh_y", "0 1 0")):
            ET.SubElement(
                body, "joint", name=name, type="slide", axis=axis, stiffness=_text(s.mass * omega**2),
                damping=_text(2.0 * s.damping_ratio * omega * s.mass),
            )  # fmt: skip
        _point(body, s.mass, np.zeros(3))
    if hidden.flexible_arm is None:
        return {}
    arm = hidden.flexible_arm
    place = _tip(vehicle, arm.rotor)
    radius = float(np.linalg.norm(place))
    across = np.cross([0.0, 0.0, 1.0], place)
    omega, inertia = 2.0 * math.pi * arm.frequency, arm.tip_mass * radius**2
    body = ET.SubElement(base, "body", name="flexible")
    ET.SubElement(
        body, "joint", name="flex", type="hinge", axis=_text(*(across / np.linalg.norm(across))),
        stiffness=_text(inertia * omega**2), damping=_text(2.0 * arm.damping_ratio * omega * inertia),
    )  # fmt: skip
    _point(body, arm.tip_mass, place)
    tilt = vehicle.rotors[arm.rotor].tilt
    return {("rotor", arm.rotor) if tilt is None else ("tilt", tilt): body}


def inside(vehicle: Vehicle, truth: Truth) -> list[tuple[float, Array, Array]]:
    """Mass, place and inertia of the attachments that are part of the truth's totals."""
    hidden, parts = truth.hidden, []
    if hidden.slosh is not None:
        parts.append((hidden.slosh.mass, np.array(hidden.slosh.place), POINT * hidden.slosh.mass * np.eye(3)))
    if hidden.flexible_arm is not None:
        arm = hidden.flexible_arm
        parts.append((arm.tip_mass, _tip(vehicle, arm.rotor), POINT * arm.tip_mass * np.eye(3)))
    return parts


def _tip(vehicle: Vehicle, rotor: int) -> Array:
    """Where the arm of a rotor ends: level with the body's origin, so that the arm is straight."""
    return np.array([*vehicle.rotors[rotor].position[:2], 0.0])


def _point(body: ET.Element, mass: float, place: Array) -> None:
    ET.SubElement(body, "inertial", pos=_text(*place), mass=_text(mass), diaginertia=_text(*(3 * [POINT * mass])))


def _text(*numbers: float) -> str:
    return " ".join(f"{x:.17g}" for x in numbers)
