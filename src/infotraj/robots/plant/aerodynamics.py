"""Rotor speeds and air: what the rotors push, and what the air takes, given the truth.

Every function is compiled and takes plain arrays; `rotor_table` and `air_table` pack a vehicle and a truth for them.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from infotraj.robots.plant import blade_elements, rotor_moments, thrust_changes
from infotraj.robots.plant.rotor_air import rotor_air
from infotraj.robots.plant.truth import Blades, Truth
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

ROTOR = np.dtype(
    [
        ("position", "f8", (3,)),  # m, at zero tilt
        ("axis", "f8", (3,)),  # at zero tilt
        ("thrust_coefficient", "f8"),  # N s^2/rad^2, true, with the coaxial loss
        ("hover", "f8"),  # rad/s, by the vehicle file
        ("exponent", "f8"),  # of the speed in the thrust
        ("spin", "f8"),  # +1: counter-clockwise from above
        ("moment", "f8"),  # m, signed: torque on the body along the axis over the thrust
        ("max_speed", "f8"),  # rad/s
        ("rise", "f8"),  # s
        ("fall", "f8"),  # s
        ("radius", "f8"),  # m
        ("arm", "i8"),  # rotors of one arm do not stand in each other's wake (that is the coaxial loss)
        ("tilt", "i8"),  # -1: fixed
        ("before", "i8"),  # tilts of the arms beside it, clockwise and counter-clockwise; -1: none
        ("after", "i8"),
        ("inertia", "f8"),  # kg m^2
        ("factor", "f8"),  # of the thrust, at this instant
        ("memory", "f8"),  # of the hysteresis, -1..1
        ("inflow", "f8"),  # m/s, mean induced velocity of the last step; 0: none yet
    ]
)

BLADE = np.dtype([(name, "f8") for name in Blades.model_fields])  # as in the truth; count 0: none

AIR = np.dtype(
    [
        ("interference_strength", "f8"),
        ("interference_spread", "f8"),
        ("axial_inflow", "f8"),
        ("rotor_drag", "f8"),
        ("linear_drag", "f8", (3,)),
        ("quadratic_drag", "f8", (3,)),
        ("angular_damping", "f8", (3,)),
        ("wind", "f8", (3,)),  # m/s, world
        ("pressure_centre", "f8", (3,)),  # m
        ("hub_moment", "f8"),
        ("translational_lift", "f8"),
        ("ground_effect", "f8"),
        ("tilt_interference", "f8"),
        ("flapping", "f8"),  # s/m
        ("hub_stiffness", "f8"),  # m
        ("hysteresis", "f8"),
        ("hysteresis_half_width", "f8"),  # rad/s
        ("supply", "f8"),  # of the thrust, by the battery, at this instant
    ]
)


def rotor_table(vehicle: Vehicle, truth: Truth) -> np.ndarray:
    """The true rotors as a record array of dtype ROTOR, (rotors,)."""
    table = np.zeros(len(vehicle.rotors), dtype=ROTOR)
    for i, rotor in enumerate(vehicle.rotors):
        row = table[i]
        row["position"], row["axis"] = rotor.position, rotor.axis
        loss = truth.air.coaxial_loss if rotor.coaxial == "lower" else 0.0
        row["thrust_coefficient"] = rotor.known_thrust_coefficient() * truth.rotors.thrust_factor[i] * (1.0 - loss)
        row["spin"], row["exponent"] = rotor.spin, truth.rotors.thrust_exponent
        share = vehicle.known_mass() * vehicle.gravity / len(vehicle.rotors)
        row["hover"] = np.sqrt(share / rotor.known_thrust_coefficient())
        row["moment"] = -rotor.spin * rotor.moment_constant * truth.rotors.moment_factor[i]
        row["max_speed"] = rotor.max_speed or np.inf
        row["rise"], row["fall"] = truth.rotors.rise_time_constant, truth.rotors.fall_time_constant
        row["radius"] = rotor.radius or 0.0
        row["tilt"] = -1 if rotor.tilt is None else rotor.tilt
        row["arm"] = i + len(vehicle.tilts) if rotor.tilt is None else rotor.tilt
        row["before"], row["after"] = neighbours(vehicle, rotor.tilt)
        row["inertia"], row["factor"] = truth.rotors.inertia, 1.0
    return table


def neighbours(vehicle: Vehicle, tilt: int | None) -> tuple[int, int]:
    """The tilts whose arms stand next to that of `tilt`, clockwise and counter-clockwise from above; -1: none."""
    if tilt is None or len(vehicle.tilts) < 2:
        return -1, -1
    angles = [float(np.arctan2(t.axis[1], t.axis[0])) for t in vehicle.tilts]
    ahead = [((a - angles[tilt]) % (2 * np.pi), i) for i, a in enumerate(angles) if i != tilt]
    return max(ahead)[1], min(ahead)[1]


def air_table(truth: Truth) -> np.ndarray:
    """The air's effects as a record array of dtype AIR, (1,)."""
    table = np.zeros(1, dtype=AIR)
    air = truth.air
    table["interference_strength"], table["interference_spread"] = air.interference.strength, air.interference.spread
    table["axial_inflow"], table["rotor_drag"] = air.axial_inflow, air.rotor_drag
    table["linear_drag"], table["quadratic_drag"] = air.linear_drag, air.quadratic_drag
    table["angular_damping"] = air.angular_damping
    table["wind"], table["pressure_centre"] = air.wind, air.pressure_centre
    table["hub_moment"], table["translational_lift"] = air.hub_moment, air.translational_lift
    table["ground_effect"], table["tilt_interference"] = air.ground_effect, air.tilt_interference
    table["flapping"], table["hub_stiffness"] = air.flapping, air.hub_stiffness
    hysteresis = truth.hidden.hysteresis
    if hysteresis is not None:
        table["hysteresis"], table["hysteresis_half_width"] = hysteresis.fraction, hysteresis.half_width
    table["supply"] = 1.0
    return table


def tilt_axes(vehicle: Vehicle) -> Array:
    """The tilts' axes, (tilts, 3)."""
    return np.array([t.axis for t in vehicle.tilts], dtype=float).reshape(-1, 3)


def blade_table(truth: Truth) -> np.ndarray:
    """The blades as a record array of dtype BLADE, (1,)."""
    table = np.zeros(1, dtype=BLADE)
    for name, value in truth.blades.model_dump().items() if truth.blades else ():
        table[name] = value
    return table


@njit(cache=True, error_model="numpy")
def turn(axis, angle, vector, out):
    """`vector` turned by `angle` (rad) about the unit `axis` (Rodrigues), into `out` (3,)."""
    c, s = np.cos(angle), np.sin(angle)
    along = (axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2]) * (1.0 - c)
    out[0] = c * vector[0] + along * axis[0] + s * (axis[1] * vector[2] - axis[2] * vector[1])
    out[1] = c * vector[1] + along * axis[1] + s * (axis[2] * vector[0] - axis[0] * vector[2])
    out[2] = c * vector[2] + along * axis[2] + s * (axis[0] * vector[1] - axis[1] * vector[0])


@njit(cache=True, error_model="numpy")
def frames(rotors, axes, tilt, position, direction):
    """Rotor places (m) and thrust axes in the body frame at true tilts (rad), into two (rotors, 3) arrays."""
    for i in range(rotors.shape[0]):
        r = rotors[i]
        if r.tilt < 0:
            position[i], direction[i] = r.position, r.axis
        else:
            turn(axes[r.tilt], tilt[r.tilt], r.position, position[i])
            turn(axes[r.tilt], tilt[r.tilt], r.axis, direction[i])


@njit(cache=True, error_model="numpy")
def spin_up(rotors, command, dt, speed, mean_square):
    """Advances `speed` (rad/s) by `dt` towards `command` by the first-order lag, exactly for a held command.

    `mean_square` becomes the squared speed at the middle of the step, so that thrust is right to second order.
    """
    for i in range(rotors.shape[0]):
        target = min(max(command[i], 0.0), rotors[i].max_speed)
        gap = speed[i] - target
        lag = rotors[i].rise if gap < 0.0 else rotors[i].fall
        half = np.exp(-0.5 * dt / lag) if lag > 0.0 else 0.0
        mean_square[i] = (target + gap * half) ** 2
        speed[i] = target + gap * half * half


@njit(cache=True, error_model="numpy")
def wake_losses(rotors, air, thrust, position, direction, loss):
    """Share of thrust that each rotor loses in the wakes of other arms' rotors, into `loss` (rotors,).

    loss_j = strength sum_i T_i / mean(T) s / sqrt(s^2 + R^2) (w_0 / w)^2 exp(-r^2 / 2 w^2) max(0, d_i . d_j): rotor j
    lies at the distance s > 0 downstream of rotor i and r beside the axis of its wake. The wake builds up over a
    radius (momentum theory: v = v_i (1 + s / sqrt(s^2 + R^2))), has the width w = 0.7 R + spread s, w_0 = 0.7 R at
    the rotor, keeps its momentum, and is an axial inflow for the rotor that stands in it.
    """
    loss[:] = 0.0
    mean = thrust.mean()
    strength = air[0].interference_strength
    if strength == 0.0 or mean <= 0.0:
        return
    spread = air[0].interference_spread
    for i in range(rotors.shape[0]):
        d = direction[i]
        radius = rotors[i].radius
        start = 0.7 * radius
        for j in range(rotors.shape[0]):
            if rotors[j].arm == rotors[i].arm:
                continue
            x = position[j, 0] - position[i, 0]
            y = position[j, 1] - position[i, 1]
            z = position[j, 2] - position[i, 2]
            s = -(x * d[0] + y * d[1] + z * d[2])
            facing = d[0] * direction[j, 0] + d[1] * direction[j, 1] + d[2] * direction[j, 2]
            if s <= 0.0 or facing <= 0.0 or start == 0.0:
                continue
            width = start + spread * s
            exponent = 0.5 * (x * x + y * y + z * z - s * s) / (width * width)
            if exponent < 20.0:
                built_up = s / np.sqrt(s * s + radius * radius)
                loss[j] += strength * thrust[i] / mean * built_up * (start / width) ** 2 * np.exp(-exponent) * facing


@njit(cache=True, error_model="numpy")
def thrusts(rotors, air, square, velocity, rate, position, direction, loss, thrust):
    """Thrust of every rotor (N), at least 0, into `thrust`.

    k_F w_h^(2-n) w^n (1 - wake loss) factor - axial_inflow w (v_r . d) + translational_lift |v_perp|^2, w_h the speed
    in hover and v_r = v_perp + (v_r . d) d. square (rotors,) speeds squared; velocity and rate (3,) of the body's
    origin, body frame, through the air.
    """
    for i in range(rotors.shape[0]):
        thrust[i] = rotors[i].thrust_coefficient * square[i]
        if rotors[i].exponent != 2.0:
            thrust[i] *= (
                (square[i] / rotors[i].hover ** 2) ** (0.5 * (rotors[i].exponent - 2.0)) if square[i] > 0 else 0
            )
    wake_losses(rotors, air, thrust, position, direction, loss)
    k, lift = air[0].axial_inflow, air[0].translational_lift
    for i in range(rotors.shape[0]):
        p, d = position[i], direction[i]
        vx, vy, vz, along = rotor_air(velocity, rate, p, d)
        own = thrust[i] * (1.0 - loss[i]) * rotors[i].factor - k * np.sqrt(square[i]) * along
        thrust[i] = max(own + lift * (vx * vx + vy * vy + vz * vz - along * along), 0.0)


@njit(cache=True, error_model="numpy")
def drag(rotors, air, square, velocity, rate, position, direction, wrench):
    """Force (N) and torque (N m) of the air about the body's origin, body frame, into `wrench` (6,).

    Rotors: -rotor_drag w v_perp at each rotor, v_perp its air velocity across its axis. Body: linear and quadratic
    drag axis by axis at the centre of pressure, and angular damping.
    """
    a = air[0]
    for c in range(3):
        wrench[c] = -(a.linear_drag[c] + a.quadratic_drag[c] * abs(velocity[c])) * velocity[c]
        wrench[3 + c] = -a.angular_damping[c] * rate[c]
    place = a.pressure_centre
    wrench[3] += place[1] * wrench[2] - place[2] * wrench[1]
    wrench[4] += place[2] * wrench[0] - place[0] * wrench[2]
    wrench[5] += place[0] * wrench[1] - place[1] * wrench[0]
    if a.rotor_drag == 0.0:
        return
    for i in range(rotors.shape[0]):
        p, d = position[i], direction[i]
        vx, vy, vz, along = rotor_air(velocity, rate, p, d)
        k = -a.rotor_drag * np.sqrt(square[i])
        fx, fy, fz = k * (vx - along * d[0]), k * (vy - along * d[1]), k * (vz - along * d[2])
        wrench[0] += fx
        wrench[1] += fy
        wrench[2] += fz
        wrench[3] += p[1] * fz - p[2] * fy
        wrench[4] += p[2] * fx - p[0] * fz
        wrench[5] += p[0] * fy - p[1] * fx


@njit(cache=True, error_model="numpy")
def rotor_wrench(rotors, thrust, position, direction, wrench):
    """Adds the rotors' force (N) and torque (N m) about the body's origin, body frame, to `wrench` (6,)."""
    for i in range(rotors.shape[0]):
        p, d = position[i], direction[i]
        fx, fy, fz = thrust[i] * d[0], thrust[i] * d[1], thrust[i] * d[2]
        wrench[0] += fx
        wrench[1] += fy
        wrench[2] += fz
        wrench[3] += p[1] * fz - p[2] * fy + rotors[i].moment * fx
        wrench[4] += p[2] * fx - p[0] * fz + rotors[i].moment * fy
        wrench[5] += p[0] * fy - p[1] * fx + rotors[i].moment * fz


@njit(cache=True, error_model="numpy")
def drive(rotors, air, blade, axes, zero, arms, arm_dofs, command, dt, speed, qpos, qvel, thrust, applied, achieved):
    """One step of the actuators and the air for the rigid-body simulation.

    Advances `speed` (rotors,) rad/s by dt towards `command`; fills `thrust` (rotors,) N, `applied` (6,): the air's
    force in the world and torque in the body frame at the origin, and `achieved` (6,): true wrench of rotors and air
    about the origin, body frame. qpos, qvel: MuJoCo's state, free joint first, arms at the addresses `arms` and
    `arm_dofs`.
    """
    n, m = rotors.shape[0], axes.shape[0]
    slope = np.empty(m)
    position, direction = np.empty((n, 3)), np.empty((n, 3))
    square, loss, tilt = np.empty(n), np.empty(n), np.empty(m)
    velocity, wrench = np.empty(3), np.zeros(6)
    for i in range(m):
        tilt[i] = qpos[arms[i]] + zero[i]
        slope[i] = qvel[arm_dofs[i]]
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    R = np.empty((3, 3))
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    wind = air[0].wind
    for c in range(3):
        velocity[c] = 0.0
        for row in range(3):
            velocity[c] += R[row, c] * (qvel[row] - wind[row])
    rate = qvel[3:6]
    spin_up(rotors, command, dt, speed, square)
    frames(rotors, axes, tilt, position, direction)
    thrust_changes.factors(rotors, air, tilt, square, qpos[2], R, position)
    thrusts(rotors, air, square, velocity, rate, position, direction, loss, thrust)
    drag(rotors, air, square, velocity, rate, position, direction, wrench)
    blade_elements.blades(rotors, blade, square, velocity, rate, position, direction, thrust, wrench)
    rotor_moments.flapping(rotors, air, thrust, velocity, rate, position, direction, wrench)
    rotor_moments.rolling(rotors, air, square, velocity, rate, position, direction, wrench)
    rotor_moments.gyroscopic(rotors, axes, slope, command, square, rate, direction, wrench)
    for c in range(3):
        applied[c] = R[c, 0] * wrench[0] + R[c, 1] * wrench[1] + R[c, 2] * wrench[2]
        applied[3 + c] = wrench[3 + c]
    rotor_wrench(rotors, thrust, position, direction, wrench)
    achieved[:] = wrench
