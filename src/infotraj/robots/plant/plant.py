"""The simulated vehicle as a robot: it flies a reference with its true body, sensors and estimator."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.dynamics.allocation import Allocation
from infotraj.errors import InfotrajError, InputError, problem
from infotraj.flight import (
    ATTITUDE,
    COMMANDED_WRENCH,
    POSITION,
    RATE,
    REFERENCE_ATTITUDE,
    REFERENCE_POSITION,
    SPECIFIC_FORCE,
    VELOCITY,
    Flight,
)
from infotraj.robots.plant import aerodynamics
from infotraj.robots.plant.disturbances import Disturbances
from infotraj.robots.plant.estimator import Estimator
from infotraj.robots.plant.hidden import Disturbance, ImuErrors
from infotraj.robots.plant.lateness import Filter, LateCommands, LateSamples, whole_steps
from infotraj.robots.plant.model import Bodies
from infotraj.robots.plant.sensors import IMU_PERIOD, MOCAP_PERIOD, Noise, turned
from infotraj.robots.plant.static import StaticPlant
from infotraj.robots.plant.supply import Drain
from infotraj.robots.plant.truth import Truth, load_truth
from infotraj.robots.robot import Controller
from infotraj.rotations import Array
from infotraj.trajectories.reference import Reference
from infotraj.vehicle import Vehicle

# A flight is lost beyond this distance from its reference (m) and above this rate (rad/s).
FAR, FAST = 20.0, 100.0
ROWS_PER_COMMAND = round(MOCAP_PERIOD / IMU_PERIOD)


class Plant:
    """A vehicle with the hidden effects of one truth, flown in MuJoCo.

    timestep: s, a whole part of the IMU's period. settle: s that the controller holds the reference's first pose
    before the flight's first row, so that its integrals find the hover (it is called with k = 0 again and again).
    mocap_delay: s from a pose's sampling to its use by the estimator. That hold begins in the true hover equilibrium,
    actuators settled.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        truth: Truth,
        *,
        timestep: float = 1e-3,
        settle: float = 10.0,
        mocap_delay: float = 0.010,
        noise: Noise | None = None,
    ) -> None:
        self._substeps = round(IMU_PERIOD / timestep)
        if self._substeps < 1 or abs(self._substeps * timestep - IMU_PERIOD) > 1e-9:
            raise InputError(
                problem(f"time step {timestep} s", f"a whole part of the IMU's {IMU_PERIOD} s", "Use 0.001.")
            )
        self.vehicle, self.truth, self.settle = vehicle, truth, settle
        self.noise = noise or Noise()
        self.bodies = Bodies(vehicle, truth, timestep)
        self.estimator = Estimator(self.noise, vehicle.gravity, mocap_delay)
        self.speed = np.zeros(len(vehicle.rotors))
        self.achieved = np.zeros(6)
        self._command = np.zeros(len(vehicle.rotors))
        self._rotors = aerodynamics.rotor_table(vehicle, truth)
        self._air = aerodynamics.air_table(truth)
        self._blade = aerodynamics.blade_table(truth)
        self._axes = aerodynamics.tilt_axes(vehicle)
        self._zero = np.array(truth.servos.zero_error if truth.servos else (), dtype=float)
        self._late = LateCommands(whole_steps(truth.hidden.command_delay, timestep, "command_delay"))
        self._imu_late = whole_steps(truth.hidden.imu.delay, timestep, "imu delay")
        self._samples = LateSamples(self._imu_late, self._substeps)
        lag = truth.hidden.imu.lag
        self._filter = Filter(lag, timestep) if lag > 0.0 else None
        self._imu_turn = rotations.matrix(rotations.exp(np.array(truth.hidden.imu.rotvec)))
        self._disturbances: Disturbances | None = None
        self._disturbed = truth.hidden.disturbance != Disturbance()
        self._gusty = truth.hidden.disturbance.gusts is not None
        self._step = 0

    @classmethod
    def load(cls, vehicle: Vehicle, path: str | Path) -> Plant:
        """The plant of a truth file. InputError, one line, where the file is not one for this vehicle."""
        return cls(vehicle, load_truth(path, vehicle))

    def reset(self, position: Array, attitude: Array, rotor_command: Array, tilt_command: Array) -> None:
        """At rest at a pose, with actuators settled at their commands."""
        self.bodies.reset(position, attitude, tilt_command)
        self.bodies.hold_load(True)
        self._step = 0
        self._late = LateCommands(whole_steps(self.truth.hidden.command_delay, self.bodies.timestep, "command_delay"))
        self._samples = LateSamples(self._imu_late, self._substeps)
        self._act(rotor_command, tilt_command)
        self.speed[:] = np.clip(rotor_command, 0.0, self._rotors["max_speed"])
        self.observe()
        if self._filter is not None:
            self._filter.settle(self._felt())

    def command(self, rotor_command: Array, tilt_command: Array) -> None:
        """Rotor speeds (rotors,) rad/s and tilts (tilts,) rad, held until the next command."""
        if self.truth.hidden.command_delay > 0:
            self._late.give(self._step, rotor_command, tilt_command)
        else:
            self._act(rotor_command, tilt_command)

    def advance(self, steps: int) -> None:
        """So many time steps of the physics."""
        for _ in range(steps):
            due = self._late.due(self._step)
            if due is not None:
                self._act(*due)
            if self._samples.wanted(self._step):
                self.observe()
                self._samples.take(self._step, self._measured())
            self._drive(self.bodies.timestep)
            self.bodies.step()
            self._step += 1
            if self._filter is not None:
                self.observe()
                self._filter.move(self._felt())

    def observe(self) -> None:
        """Thrusts, accelerations and sensors of the present instant."""
        self._drive(0.0)
        self.bodies.forward()

    def fly(self, reference: Reference, controller: Controller, rng: np.random.Generator) -> Flight:
        """The flight table at 200 Hz: sensors, estimate, commands and reference; nothing of the truth.

        InputError where the reference's or the controller's period is not 0.01 s; InfotrajError, one line, where the
        flight diverges.
        """
        return self.fly_with_truth(reference, controller, rng)[0]

    def fly_with_truth(
        self, reference: Reference, controller: Controller, rng: np.random.Generator
    ) -> tuple[Flight, pd.DataFrame]:
        """The flight, and the true motion beside it: for tests, recordings and tables only.

        The second table has, at the same times, the true px..qz, vx.., wx.., ax.. (specific force), alphax..
        (rad/s^2, body), fx..tz (wrench of rotors and air about the origin, body), rotor_i (rad/s), thrust_i (N) and
        tilt_i (rad).
        """
        for what, period in (("reference's sample time", reference.dt), ("controller's period", controller.period)):
            if abs(period - MOCAP_PERIOD) > 1e-6:
                raise InputError(problem(f"a {what} of {period:g} s", f"{MOCAP_PERIOD} s", "Resample it."))
        settle = round(self.settle / MOCAP_PERIOD) * ROWS_PER_COMMAND
        rows = settle + len(reference.t) * ROWS_PER_COMMAND
        gyro_noise, force_noise = self.noise.imu(rng, rows)
        place_noise, turn_noise = self.noise.mocap(rng, rows // ROWS_PER_COMMAND)
        bodies, estimator, n, m = self.bodies, self.estimator, len(self.vehicle.rotors), len(self.vehicle.tilts)
        true = np.empty((rows, 25 + 2 * n + m))
        imu, pose = np.empty((rows, 6)), np.full((rows, 7), np.nan)
        estimates, commands = np.empty((rows, 13)), np.empty((rows, 6 + n + m))
        # streams of their own: what a truth hides does not change the sensors' noise
        weather, drain_noise = rng.spawn(2)
        hidden = self.truth.hidden
        self._disturbances = Disturbances(hidden.disturbance, rows, IMU_PERIOD, weather)
        drain = Drain(hidden.supply, IMU_PERIOD, drain_noise) if hidden.supply else None
        volts = np.full(rows, np.nan)
        controller.reset()
        self._hover(reference)
        for k in range(rows):
            self._disturbances.begin(k)
            if k == settle:
                bodies.hold_load(False)
            if drain is not None:
                self._air[0]["supply"] = drain.advance(self.speed, k >= settle)
                volts[k] = drain.log()
            self.observe()
            row = true[k]
            row[:7], row[7:13] = bodies.qpos[:7], bodies.qvel[:6]
            row[13:16], row[16:19], row[19:25] = bodies.specific_force, bodies.angular_acceleration, self.achieved
            row[25 : 25 + n], row[25 + n : 25 + 2 * n], row[25 + 2 * n :] = self.speed, bodies.thrust, bodies.tilts()
            sample = self._samples.read(self._step, self._measured()) if self._imu_late else self._measured()
            imu[k, :3] = sample[:3] + gyro_noise[k]
            imu[k, 3:] = sample[3:] + force_noise[k]
            if k % ROWS_PER_COMMAND == 0:
                at = k // ROWS_PER_COMMAND
                pose[k, :3] = bodies.position + place_noise[at]
                turned(bodies.attitude, turn_noise[at], pose[k, 3:])
            if k == 0:
                estimator.start(pose[0, :3], pose[0, 3:])
            estimator.integrate(imu[k, :3], imu[k, 3:])
            arrived = k - estimator.delay_rows
            if arrived >= 0 and arrived % ROWS_PER_COMMAND == 0:
                estimator.correct(pose[arrived, :3], pose[arrived, 3:])
            estimate = estimator.estimate()
            row = estimates[k]
            row[:3], row[3:7], row[7:10] = estimate.position, estimate.attitude, estimate.velocity
            row[10:13] = estimate.rate
            if k % ROWS_PER_COMMAND == 0:
                step = max(k - settle, 0) // ROWS_PER_COMMAND
                wrench, rotor_command, tilt_command = controller.command(step, estimate)
                row = commands[k]
                row[:6], row[6 : 6 + n], row[6 + n :] = wrench, rotor_command, tilt_command
                self._check(row, reference.position[step], (k - settle) * IMU_PERIOD)
                self.command(rotor_command, tilt_command)
            else:
                commands[k] = commands[k - 1]
            self.advance(self._substeps)
        keep = slice(settle, rows)
        flight = self._flight(reference, imu[keep], pose[keep], estimates[keep], commands[keep])
        if np.isfinite(volts).any():
            flight = Flight(flight.table.assign(battery=volts[keep]), flight.meta)
        return flight, self._truth_table(true[keep])

    def _hover(self, reference: Reference) -> None:
        attitude = reference.attitude[0]
        if not self.vehicle.tilts:  # it can only hover level
            attitude = rotations.from_euler(0.0, 0.0, rotations.to_euler(attitude)[2])
        up = rotations.to_body(attitude, np.array([0.0, 0.0, 1.0]))
        wrench = StaticPlant(self.vehicle, self.truth).hold(up)
        self.reset(reference.position[0], attitude, *Allocation(self.vehicle).actuators(wrench))

    def _act(self, rotor_command: Array, tilt_command: Array) -> None:
        self._command[:] = rotor_command
        self.bodies.servo[:] = tilt_command

    def _measured(self) -> Array:
        """What the IMU measures at this instant, without noise: gyro and specific force (6,)."""
        imu = self.truth.hidden.imu
        felt = self._felt() if self._filter is None else self._filter.value
        if imu == ImuErrors():
            return felt
        rate, force = self._imu_turn @ felt[:3], self._imu_turn @ felt[3:]
        return np.concatenate([rate + np.array(imu.gyro_bias), force + np.array(imu.accelerometer_bias)])

    def _felt(self) -> Array:
        """Rate and specific force (6,) of the body at this instant."""
        return np.concatenate([self.bodies.gyro, self.bodies.specific_force])

    def _drive(self, dt: float) -> None:
        b = self.bodies
        through_air = b.qvel
        if self._gusty and self._disturbances is not None:
            through_air = b.qvel.copy()
            through_air[:3] -= self._disturbances.wind
        aerodynamics.drive(
            self._rotors, self._air, self._blade, self._axes, self._zero, b.arm_address, b.arm_dofs, self._command, dt,
            self.speed, b.qpos, through_air, b.thrust, b.applied, self.achieved,
        )  # fmt: skip
        if self._disturbed and self._disturbances is not None:
            self._disturbances.add(b.position, b.attitude, b.applied)

    def _check(self, command: Array, goal: Array, t: float) -> None:
        self.bodies.check(t)
        if not np.isfinite(command).all():
            raise InfotrajError(
                problem(
                    f"{self.truth.name}: the controller's command at t = {t:.2f} s is not finite",
                    "numbers",
                    "Check its gains and limits.",
                )
            )
        distance = float(np.linalg.norm(self.bodies.position - goal))
        spin = float(np.linalg.norm(self.bodies.rate))
        if distance > FAR or spin > FAST:
            raise InfotrajError(
                problem(
                    f"{self.truth.name}: {distance:.3g} m from its reference, turning at {spin:.3g} rad/s at {t:.2f} s",
                    f"less than {FAR:g} m and {FAST:g} rad/s",
                    "The closed loop is unstable: check the controller's gains and the reference's accelerations.",
                )
            )

    def _flight(self, reference: Reference, imu: Array, pose: Array, estimates: Array, commands: Array) -> Flight:
        columns: dict[str, Array] = {"t": np.round(np.arange(len(imu)) * IMU_PERIOD, 9)}
        _add(columns, POSITION + ATTITUDE, pose)
        _add(columns, RATE + SPECIFIC_FORCE, imu)
        _add(columns, tuple(f"est_{c}" for c in POSITION + ATTITUDE + VELOCITY + RATE), estimates)
        _add(columns, COMMANDED_WRENCH, commands[:, :6])
        n = len(self.vehicle.rotors)
        for i in range(n):
            columns[f"cmd_rotor_{i}"] = commands[:, 6 + i]
        for i in range(len(self.vehicle.tilts)):
            columns[f"cmd_tilt_{i}"] = commands[:, 6 + n + i]
        half = np.arange(len(imu)) / ROWS_PER_COMMAND
        lower = half.astype(int)
        upper = np.minimum(lower + 1, len(reference.t) - 1)
        share = (half - lower)[:, None]
        _add(columns, REFERENCE_POSITION, _between(reference.position, lower, upper, share))
        attitude = rotations.continuous(reference.attitude)
        _add(columns, REFERENCE_ATTITUDE, rotations.normalize(_between(attitude, lower, upper, share)))
        meta = {
            "vehicle": self.vehicle.name,
            "robot": f"mujoco {self.truth.name}",
            "imu_rate": round(1 / IMU_PERIOD),
            "mocap_rate": round(1 / MOCAP_PERIOD),
            "command_rate": round(1 / MOCAP_PERIOD),
            "estimator": self.estimator.description,
            "estimator_delay": self.estimator.delay,
        }
        return Flight(pd.DataFrame(columns), meta)

    def _truth_table(self, true: Array) -> pd.DataFrame:
        n, m = len(self.vehicle.rotors), len(self.vehicle.tilts)
        names = (
            *POSITION, *ATTITUDE, *VELOCITY, *RATE, *SPECIFIC_FORCE, "alphax", "alphay", "alphaz",
            "fx", "fy", "fz", "tx", "ty", "tz",
            *(f"rotor_{i}" for i in range(n)), *(f"thrust_{i}" for i in range(n)), *(f"tilt_{i}" for i in range(m)),
        )  # fmt: skip
        columns: dict[str, Array] = {"t": np.round(np.arange(len(true)) * IMU_PERIOD, 9)}
        _add(columns, names, true)
        return pd.DataFrame(columns)


def _add(columns: dict[str, Array], names: tuple[str, ...], values: Array) -> None:
    columns.update(zip(names, values.T, strict=True))


def _between(samples: Array, lower: Array, upper: Array, share: Array) -> Array:
    return (1.0 - share) * samples[lower] + share * samples[upper]
