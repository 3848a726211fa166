"""The plant's bodies in MuJoCo: a free body, an arm for each tilt, a thruster for each rotor. Imports mujoco alone.

Each tilt's servo is a position actuator with limited force on a damped hinge, J q'' = clip(kp (r - q), +-F) - kv q'.
At the limit it turns at F / kv, its greatest rate; below, it is the second-order servo that the truth states, or with
a small J / kv the first-order lag kv / kp. Dead time is the actuator's `delay`. Where there is play, the servo is a
hinge of its own and a tendon with a small range couples it to the arm, which stays where its bearing holds it. A zero
error turns the arm's frame against its joint. The rotor's reaction torque is its thruster's `gear`.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from infotraj.errors import InfotrajError, InputError, problem
from infotraj.robots.plant import attachments
from infotraj.robots.plant.truth import Lag, Truth
from infotraj.rotations import Array, exp
from infotraj.vehicle import Vehicle

# Reflected inertia of a servo and its load, kg m^2: with the 2020 servo's damping, 8 rad/s then take 1.4 N m, the
# stall torque of the Dynamixel XL430 class that turns such arms (assumed). A gear's armature has no reaction.
SERVO_INERTIA = 0.011
# The play's stop: time constant of its contact (s), twice the time step, the shortest that MuJoCo takes.
STOP_TIME_CONSTANT = 2e-3
# A hinge needs a body; the servo's side of the play is this light (kg, kg m^2).
# Armature (kg m^2) of an arm that is placed and not moved by forces: an armature has no reaction on the body.
HELD = 1e3
HORN_MASS, HORN_INERTIA = 1e-6, 1e-9


class Bodies:
    """The compiled model with its state, and views into it that stay valid.

    position (3,) m and velocity (3,) m/s, world; attitude (4,) w, x, y, z; rate (3,) rad/s, body; tilt addresses of
    the arms in qpos; thrust (rotors,) N and servo (tilts,) rad, the controls; applied (6,): force (N) in the world,
    torque (N m) in the body frame, at the body's origin; specific_force (3,) m/s^2 and gyro (3,) rad/s at the origin.
    """

    def __init__(self, vehicle: Vehicle, truth: Truth, timestep: float) -> None:
        truth.check(vehicle, truth.name)
        self.name, self.timestep = truth.name, timestep
        self.model = mujoco.MjModel.from_xml_string(model_xml(vehicle, truth, timestep))
        self.data = mujoco.MjData(self.model)
        n, m = len(vehicle.rotors), len(vehicle.tilts)
        d = self.data
        self.qpos, self.qvel, self.qacc = d.qpos, d.qvel, d.qacc
        self.position, self.attitude = d.qpos[0:3], d.qpos[3:7]
        self.velocity, self.rate = d.qvel[0:3], d.qvel[3:6]
        self.angular_acceleration = d.qacc[3:6]
        self.thrust, self.servo = d.ctrl[:n], d.ctrl[n : n + m]
        self.applied = d.qfrc_applied[:6]
        self.specific_force, self.gyro = d.sensordata[0:3], d.sensordata[3:6]
        self.arm_address = np.array([self.model.joint(f"arm_{i}").qposadr[0] for i in range(m)], dtype=np.int64)
        self.arm_dofs = np.array([self.model.joint(f"arm_{i}").dofadr[0] for i in range(m)], dtype=np.int64)
        self._horn_address = [
            self.model.joint(f"servo_{i}").qposadr[0] if has_horn(truth, i) else None for i in range(m)
        ]
        self._backlash = truth.hidden.backlash
        self._zero = np.array(truth.servos.zero_error if truth.servos else (), dtype=float)
        self._rotors = n
        self._load = self.model.body("load").id if truth.hidden.load else None
        self._brake = 0.0

    def hold_load(self, held: bool) -> None:
        """Whether what hangs on a cable is braked: it is until a flight begins, so that it hangs at rest then."""
        if self._load is not None:
            self._brake = attachments.BRAKE * self.model.body_mass[self._load] if held else 0.0
            self.data.xfrc_applied[self._load] = 0.0

    def reset(self, position: Array, attitude: Array, tilt_command: Array) -> None:
        """At rest at a pose, servos settled at their commands (tilts,) rad for longer than any dead time."""
        mujoco.mj_resetData(self.model, self.data)
        self.position[:], self.attitude[:] = position, attitude
        self.servo[:] = tilt_command
        for i, angle in enumerate(tilt_command):
            self.qpos[self.arm_address[i]] = angle
            if self._horn_address[i] is not None:
                self.qpos[self._horn_address[i]] = angle
            actuator = self._rotors + i
            samples = self.model.actuator_history[actuator, 0]
            if samples > 0:
                mujoco.mj_initCtrlHistory(self.model, self.data, actuator, None, np.full(samples, float(angle)))

    def forward(self) -> None:
        """Accelerations and sensors of the present state; time stands."""
        mujoco.mj_forward(self.model, self.data)

    def step(self) -> None:
        """One time step with the present controls and applied force."""
        if self._brake:
            velocity = np.zeros(6)
            mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_BODY, self._load, velocity, 0)
            self.data.xfrc_applied[self._load, :3] = -self._brake * velocity[3:]
        mujoco.mj_step(self.model, self.data)
        if self._backlash:
            self._drag_arms()

    def _drag_arms(self) -> None:
        """The servos' horns take the arms along once they have crossed the play; else the arms stay where they are."""
        for arm, dof, horn in zip(self.arm_address, self.arm_dofs, self._horn_address, strict=True):
            low, high = self.qpos[horn] - self._backlash, self.qpos[horn] + self._backlash
            self.qpos[arm] = min(max(self.qpos[arm], low), high)
            self.qvel[dof] = 0.0

    def tilts(self) -> Array:
        """True tilts (tilts,) rad: where the arms stand, zero error included."""
        return self.qpos[self.arm_address] + self._zero

    def check(self, t: float) -> None:
        """InfotrajError, one line with the flight's time t (s), once a state or a control is no number or too large."""
        bad = [
            name
            for name, kind in (
                ("position", mujoco.mjtWarning.mjWARN_BADQPOS),
                ("velocity", mujoco.mjtWarning.mjWARN_BADQVEL),
                ("acceleration", mujoco.mjtWarning.mjWARN_BADQACC),
                ("control", mujoco.mjtWarning.mjWARN_BADCTRL),
            )
            if self.data.warning[kind].number
        ]
        if bad:
            raise InfotrajError(
                problem(
                    f"{self.name}: the simulation diverged before t = {t:.2f} s ({', '.join(bad)})",
                    "finite states and commands",
                    "Check the controller's gains and commands.",
                )
            )

    def momentum(self) -> tuple[Array, Array]:
        """Linear (kg m/s) and angular momentum (kg m^2/s) about the total centre of mass, world axes, (3,) each."""
        m, d = self.model, self.data
        mujoco.mj_forward(m, d)
        mujoco.mj_subtreeVel(m, d)
        return m.body_subtreemass[1] * d.subtree_linvel[1], d.subtree_angmom[1].copy()

    def energy(self) -> float:
        """Potential and kinetic energy (J), the servos' turning gears included."""
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        return float(self.data.energy.sum())


def model_xml(vehicle: Vehicle, truth: Truth, timestep: float) -> str:
    """The MJCF of a plant. Totals of mass, centre of mass and inertia at zero tilts are exactly the truth's."""
    root = ET.Element("mujoco", model=truth.name)
    ET.SubElement(root, "compiler", angle="radian", inertiafromgeom="false", autolimits="true")
    option = ET.SubElement(
        root, "option", timestep=_text(timestep), gravity=_text(0, 0, -vehicle.gravity), integrator="implicitfast"
    )
    # MuJoCo would otherwise answer NaN with a silent restart.
    ET.SubElement(option, "flag", autoreset="disable", contact="disable")
    worldbody = ET.SubElement(root, "worldbody")
    base = ET.SubElement(worldbody, "body", name="vehicle")
    ET.SubElement(base, "freejoint", name="free")
    _inertial(base, *_base_inertia(vehicle, truth))
    ET.SubElement(base, "site", name="imu")
    actuators, tendons = ET.Element("actuator"), ET.Element("tendon")
    roots = attachments.attach(base, vehicle, truth)
    arms = [_arm(base, roots.get(("tilt", i), base), tendons, vehicle, truth, i) for i in range(len(vehicle.tilts))]
    for i, rotor in enumerate(vehicle.rotors):
        body = roots.get(("rotor", i), base) if rotor.tilt is None else arms[rotor.tilt]
        ET.SubElement(body, "site", name=rotor.name, pos=_text(*rotor.position), zaxis=_text(*rotor.axis))
        torque = -rotor.spin * rotor.moment_constant * truth.rotors.moment_factor[i]
        ET.SubElement(actuators, "motor", name=rotor.name, site=rotor.name, gear=_text(0, 0, 1, 0, 0, torque))
    for i in range(len(vehicle.tilts)):
        _servo(actuators, truth, i, timestep)
    root.append(actuators)
    if len(tendons):
        root.append(tendons)
    sensor = ET.SubElement(root, "sensor")
    ET.SubElement(sensor, "accelerometer", site="imu")
    ET.SubElement(sensor, "gyro", site="imu")
    return ET.tostring(root, encoding="unicode")


def servo_gains(truth: Truth) -> tuple[float, float, float]:
    """Stiffness kp (N m/rad), damping kv (N m s/rad) and force limit F (N m) of a tilt's servo."""
    servos, _ = truth.tilting()
    servo = servos.dynamics
    if isinstance(servo, Lag):
        kv = SERVO_INERTIA / min(servo.fast_time_constant, 0.25 * servo.time_constant)
        kp = kv / servo.time_constant
    else:
        kp = SERVO_INERTIA * servo.natural_frequency**2
        kv = 2.0 * servo.damping_ratio * servo.natural_frequency * SERVO_INERTIA
    return kp, kv, kv * servos.max_rate


def has_horn(truth: Truth, i: int) -> bool:
    """Whether servo i has a hinge of its own: there is play between it and the arm."""
    return truth.tilting()[0].play[i] > 0 or truth.hidden.backlash > 0


def _arm(base: ET.Element, root: ET.Element, tendons: ET.Element, vehicle: Vehicle, truth: Truth, i: int) -> ET.Element:
    axis = vehicle.tilts[i].axis
    _, kv, _ = servo_gains(truth)
    servos, of_arm = truth.tilting()
    armature, damping = SERVO_INERTIA - of_arm.inertia[0], kv - of_arm.bearing_damping
    if armature <= 0 or damping <= 0:
        raise InputError(
            problem(
                f"{truth.name}: arm inertia {of_arm.inertia[0]} kg m^2 or bearing damping "
                f"{of_arm.bearing_damping} N m s/rad is more than its servo moves",
                f"below {SERVO_INERTIA} kg m^2 and {kv:.3g} N m s/rad",
                "Make the arm lighter.",
            )
        )
    arm = ET.SubElement(root, "body", name=f"arm_{i}", quat=_text(*exp(servos.zero_error[i] * np.asarray(axis))))
    joint = ET.SubElement(arm, "joint", name=f"arm_{i}", type="hinge", axis=_text(*axis))
    mass, center, inertia = _arm_inertia(vehicle, truth, i)
    _inertial(arm, mass, center, inertia)
    play = servos.play[i]
    if not has_horn(truth, i):
        joint.set("armature", _text(armature))
        joint.set("damping", _text(kv))
        return arm
    joint.set("damping", _text(of_arm.bearing_damping))
    if truth.hidden.backlash:
        joint.set("armature", _text(HELD))
    horn = ET.SubElement(base, "body", name=f"servo_{i}")
    ET.SubElement(
        horn, "joint", name=f"servo_{i}", type="hinge", axis=_text(*axis), armature=_text(armature),
        damping=_text(damping),
    )  # fmt: skip
    _inertial(horn, HORN_MASS, np.zeros(3), HORN_INERTIA * np.eye(3))
    if truth.hidden.backlash:
        return arm
    fixed = ET.SubElement(
        tendons, "fixed", name=f"play_{i}", range=_text(-play, play), solreflimit=_text(STOP_TIME_CONSTANT, 1.0)
    )
    ET.SubElement(fixed, "joint", joint=f"servo_{i}", coef="1")
    ET.SubElement(fixed, "joint", joint=f"arm_{i}", coef="-1")
    return arm


def _servo(actuators: ET.Element, truth: Truth, i: int, timestep: float) -> None:
    kp, _, limit = servo_gains(truth)
    joint = f"servo_{i}" if has_horn(truth, i) else f"arm_{i}"
    servo = ET.SubElement(
        actuators, "position", name=f"servo_{i}", joint=joint, kp=_text(kp), forcerange=_text(-limit, limit)
    )
    dead_time = getattr(truth.tilting()[0].dynamics, "dead_time", 0.0)
    if dead_time > 0:
        servo.set("delay", _text(dead_time))
        servo.set("nsample", str(math.ceil(dead_time / timestep - 1e-9)))


def _arm_inertia(vehicle: Vehicle, truth: Truth, i: int) -> tuple[float, Array, Array]:
    """Mass, centre and inertia about it of arm i at zero tilt, in the body's frame."""
    axis = np.asarray(vehicle.tilts[i].axis)
    rotors = [r for r in vehicle.rotors if r.tilt == i]
    along = float(np.mean([np.dot(axis, r.position) for r in rotors])) if rotors else 0.0
    thrust = np.asarray(rotors[0].axis if rotors else (0.0, 0.0, 1.0))
    thrust = thrust - np.dot(thrust, axis) * axis
    thrust /= np.linalg.norm(thrust)
    axes = np.column_stack([axis, np.cross(thrust, axis), thrust])
    arm = truth.tilting()[1]
    return arm.mass, along * axis, axes @ np.diag(arm.inertia) @ axes.T


def _base_inertia(vehicle: Vehicle, truth: Truth) -> tuple[float, Array, Array]:
    """What is left for the free body when the arms are taken out of the truth's totals."""
    parts = [_arm_inertia(vehicle, truth, i) for i in range(len(vehicle.tilts))]
    if truth.servos:
        parts += [
            (HORN_MASS, np.zeros(3), HORN_INERTIA * np.eye(3)) for i in range(len(vehicle.tilts)) if has_horn(truth, i)
        ]
    parts += attachments.inside(vehicle, truth)
    mass = truth.mass - sum(p[0] for p in parts)
    center = np.asarray(truth.center_of_mass)
    about_origin = truth.inertia.matrix() + _steiner(truth.mass, center)
    moment = truth.mass * center
    for part_mass, place, inertia in parts:
        about_origin -= inertia + _steiner(part_mass, place)
        moment = moment - part_mass * place
    if mass > 0:
        center = moment / mass
        inertia = about_origin - _steiner(mass, center)
        principal = np.linalg.eigvalsh(inertia)
        if principal[0] > 0 and principal[0] + principal[1] >= principal[2]:
            return mass, center, inertia
    raise InputError(
        problem(
            f"{truth.name}: no body is left when the arms of {truth.arm.mass if truth.arm else 0} kg are taken out",
            "a positive mass and an inertia that a body can have",
            "Make `arm` lighter.",
        )
    )


def _steiner(mass: float, r: Array) -> Array:
    return mass * (np.dot(r, r) * np.eye(3) - np.outer(r, r))


def _inertial(body: ET.Element, mass: float, center: Array, inertia: Array) -> None:
    full = (inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2])
    ET.SubElement(body, "inertial", pos=_text(*center), mass=_text(mass), fullinertia=_text(*full))


def _text(*numbers: float) -> str:
    return " ".join(f"{x:.17g}" for x in numbers)
