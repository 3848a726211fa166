"""The vehicle in 3D: body, arms that tilt, rotor discs, thrust arrows, and the paths it was asked to fly and flew."""

from __future__ import annotations

import numpy as np
import rerun as rr

from infotraj import rotations
from infotraj.dynamics.actuators import thrusts
from infotraj.flight import ATTITUDE, POSITION, REFERENCE_ATTITUDE, REFERENCE_POSITION, Flight
from infotraj.recording.signals import Samples, actuators, at, channel, estimated, thinned
from infotraj.recording.stream import Columns
from infotraj.rotations import Array
from infotraj.vehicle import Rotor, Vehicle

RATE = 50.0  # samples a second: what an eye follows
FLOWN, REFERENCE = (0, 158, 115), (230, 159, 0)
BODY, ARM, THRUST = (70, 80, 95), (150, 160, 175), (213, 94, 0)
SPIN_COLORS = {1: (86, 180, 233), -1: (204, 121, 167)}
VEHICLE = "world/vehicle"


def reach(vehicle: Vehicle) -> float:
    """Distance (m) from the origin to the farthest rotor's edge, the scale of everything drawn; 0.1 without rotors."""
    edges = [float(np.linalg.norm(r.position)) + (r.radius or 0.0) for r in vehicle.rotors]
    return max(max(edges, default=0.1), 0.02)


def add_scene(columns: Columns, flight: Flight, vehicle: Vehicle) -> None:
    """Adds the vehicle and both paths, as far as the flight has a pose and commands."""
    columns.static("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    size = reach(vehicle)
    pose = _pose(flight, POSITION, ATTITUDE, estimate=True)
    wanted = _pose(flight, REFERENCE_POSITION, REFERENCE_ATTITUDE, estimate=False)
    if wanted is not None:
        _add_path(columns, "world/reference", wanted, REFERENCE, size)
    if pose is not None:
        _add_path(columns, "world/flown", pose, FLOWN, size)
        columns.pose(VEHICLE, pose[0], translation=pose[1], attitude=pose[2])
    _add_vehicle(columns, flight, vehicle, size)


def center_of(flight: Flight) -> tuple[Array, float]:
    """Middle (3,) m and largest extent (m) of the flown path, or of the reference, or the origin."""
    found = estimated(flight, POSITION) or channel(flight, REFERENCE_POSITION)
    if found is None:
        return np.zeros(3), 0.0
    low, high = found.values.min(axis=0), found.values.max(axis=0)
    return 0.5 * (low + high), float((high - low).max())


def _pose(flight: Flight, place: tuple, turn: tuple, *, estimate: bool) -> tuple[Array, Array, Array] | None:
    find = estimated if estimate else channel
    position, attitude = find(flight, place), find(flight, turn)
    longest = position or attitude
    if longest is None:
        return None
    t = longest.t
    t = t[thinned(t, RATE)]
    where = np.zeros((len(t), 3)) if position is None else at(position, t)
    if attitude is None:
        return t, where, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
    smooth = Samples(attitude.t, rotations.continuous(rotations.normalize(attitude.values)))
    return t, where, rotations.normalize(at(smooth, t))


def _add_path(columns: Columns, entity: str, pose: tuple[Array, Array, Array], color: tuple, size: float) -> None:
    """The path of the origin, and that of a tip one `size` above it, which shows how the attitude moves."""
    t, where, turn = pose
    tip = where + rotations.to_world(turn, np.array([0.0, 0.0, 1.4 * size]))
    columns.static(f"{entity}/path", rr.LineStrips3D([where], colors=color, radii=0.007 * size))
    columns.static(f"{entity}/tip_path", rr.LineStrips3D([tip], colors=color, radii=0.007 * size))
    columns.static(f"{entity}/body_z", rr.Arrows3D.from_fields(colors=color, radii=0.010 * size))
    columns.arrow(f"{entity}/body_z", t, where, tip - where)


def _add_vehicle(columns: Columns, flight: Flight, vehicle: Vehicle, size: float) -> None:
    columns.static(
        f"{VEHICLE}/body",
        rr.Ellipsoids3D(half_sizes=[[0.28 * size, 0.28 * size, 0.12 * size]], colors=BODY, fill_mode="solid"),
    )
    columns.static(
        f"{VEHICLE}/forward",
        rr.Arrows3D(
            origins=[[0.25 * size, 0, 0]], vectors=[[0.35 * size, 0, 0]], colors=(220, 50, 47), radii=0.02 * size
        ),
    )
    tilt = actuators(flight, "tilt", len(vehicle.tilts))
    for i, joint in enumerate(vehicle.tilts):
        if tilt is not None:
            keep = thinned(tilt.t, RATE)
            turned = rotations.exp(tilt.values[keep, i : i + 1] * np.asarray(joint.axis))
            columns.pose(f"{VEHICLE}/{joint.name}", tilt.t[keep], attitude=turned)
    given = actuators(flight, "rotor", len(vehicle.rotors))
    force = None if given is None else Samples(given.t, thrusts(vehicle, given.values))
    newton = _metres_per_newton(vehicle, force, size)
    for i, rotor in enumerate(vehicle.rotors):
        parent = VEHICLE if rotor.tilt is None else f"{VEHICLE}/{vehicle.tilts[rotor.tilt].name}"
        _add_rotor(columns, f"{parent}/{rotor.name}", rotor, size)
        if force is not None:
            keep = thinned(force.t, RATE)
            vector = newton * force.values[keep, i : i + 1] * np.asarray(rotor.axis)
            # A lower rotor's arrow ends at its disc, so that the two of a coaxial pair do not cover each other.
            origin = np.asarray(rotor.position) - (vector if rotor.coaxial == "lower" else 0.0 * vector)
            arrow = f"{parent}/{rotor.name}/thrust"
            columns.static(arrow, rr.Arrows3D.from_fields(colors=THRUST, radii=0.022 * size))
            columns.arrow(arrow, force.t[keep], origin, vector)


def _add_rotor(columns: Columns, entity: str, rotor: Rotor, size: float) -> None:
    place, axis = np.asarray(rotor.position), np.asarray(rotor.axis)
    hub = place - np.dot(place, axis) * axis if rotor.coaxial else place
    columns.static(
        f"{entity}/arm", rr.LineStrips3D([np.array([np.zeros(3), hub, place])], colors=ARM, radii=0.025 * size)
    )
    columns.static(
        f"{entity}/disc",
        rr.Cylinders3D(
            lengths=0.03 * size,
            radii=rotor.radius or 0.25 * size,
            centers=[place],
            quaternions=[_from_z(axis)[[1, 2, 3, 0]]],
            colors=SPIN_COLORS[rotor.spin],
            fill_mode="solid",
        ),
    )


def _from_z(axis: Array) -> Array:
    """Quaternion (4,) that turns z onto the unit `axis`."""
    half = np.array([1.0 + axis[2], -axis[1], axis[0], 0.0])
    return rotations.normalize(half) if axis[2] > -1.0 + 1e-9 else np.array([0.0, 1.0, 0.0, 0.0])


def _metres_per_newton(vehicle: Vehicle, force: Samples | None, size: float) -> float:
    """Length of a thrust arrow: a rotor's share of the weight, or its median thrust, is half the vehicle's reach."""
    if not vehicle.rotors:
        return 0.0
    if vehicle.mass is not None:
        usual = vehicle.mass * vehicle.gravity / len(vehicle.rotors)
    else:
        usual = 0.0 if force is None else float(np.median(force.values))
    return 0.5 * size / usual if usual > 0 else 0.0
