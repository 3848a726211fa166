"""A model: the vehicle file's physics with any set of effects, evaluated along recorded flights."""

from __future__ import annotations

import copy
from collections.abc import Hashable, Iterable
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from infotraj.effects.along import Along
from infotraj.effects.base import Effect, overrides
from infotraj.effects.channels import missing_channel
from infotraj.effects.laws import ActuatorLaw, AirLaw, BodyLaw, ImuLaw
from infotraj.errors import InputError, UsageError, problem
from infotraj.flight import Flight
from infotraj.models import body
from infotraj.models.kinematics import kinematics
from infotraj.models.prediction import AXES, Prediction
from infotraj.models.prepared import Prepared, Segment
from infotraj.models.recorded import Samples
from infotraj.models.rotor_wrench import forces_at_rotors
from infotraj.models.sensor_lag import as_sensed
from infotraj.rotations import Array, Mask
from infotraj.vehicle import Vehicle

_STALE = 10.0  # usual intervals without a command, after which it is no longer believed
_STALE_AT_LEAST = 0.25  # s


class Model:
    """A vehicle and what is missing from its file: any effects, each once, or once a rotor where it is of one.

    The effects act in the catalogue's order: actuators (delay, lag, rate limit, play, bias), thrust, wrench, rigid
    body, measurement. InputError where an effect does not fit the vehicle; UsageError where one stands twice.
    """

    def __init__(self, vehicle: Vehicle, effects: Iterable[Effect] = ()) -> None:
        self.vehicle = vehicle
        self.effects = tuple(effects)
        labels = [e.label if e.repeatable else e.name for e in self.effects]
        twice = sorted({x for x in labels if labels.count(x) > 1})
        if twice:
            raise UsageError(problem(f"the effect {twice[0]} stands twice", "once", "Fit its parameters instead."))
        for effect in self.effects:
            effect.check(vehicle)
        self._acting = tuple(e for e in self.effects if not e.is_absent(vehicle))
        self._by_hook: dict[str, list[Effect]] = {}
        self._keys: dict[tuple[str, ...], Hashable] = {}

    @cached_property
    def key(self) -> Hashable:
        """What tells it from other models of its vehicle."""
        return tuple(e.key for e in self._acting)

    def with_effects(self, *effects: Effect) -> Model:
        """A model with further effects."""
        return Model(self.vehicle, (*self.effects, *effects))

    def prepare(self, flight: Flight) -> Prepared:
        """The flight made ready for many predictions by models of this vehicle."""
        return Prepared(self.vehicle, flight)

    def predict(self, flight: Flight | Prepared) -> Prediction:
        """What the sensors should have measured along the flight.

        InputError where the flight lacks a channel that the rotors or an effect of this model need.
        """
        prepared = flight if isinstance(flight, Prepared) else Prepared(self.vehicle, flight)
        if prepared.vehicle is not self.vehicle and prepared.vehicle != self.vehicle:
            raise UsageError(problem("a flight prepared for another vehicle", self.vehicle.name, "Prepare it again."))
        prepared.kept.get("channels", self.key, lambda: self._check_channels(prepared.flight))
        law, imu = prepared.as_logged(self.actuator_law, self.imu_law)
        frame, air = self.body_law, self.air_law
        n, rows = len(prepared.recorded.t), list[Array]()
        for s in prepared.segments(imu, law):
            found = self._segment(prepared, s, prepared.along(s, imu, law, air, self._flown), imu, law, frame)
            if (s.start, s.stop) == (0, n):
                rows = found
                break
            rows = rows or [np.full((n, 3), np.nan) for _ in found]
            for whole, part in zip(rows, found, strict=True):
                whole[s.start : s.stop] = part  # the last row again by the next one, which knows the step after it
        sensed = as_sensed(prepared.recorded, rows, imu.lag)
        if imu.turned:
            sensed = [x @ imu.rotation.T for x in sensed]
        force, force_mean, turn, turn_mean = sensed
        return Prediction(
            prepared.recorded.t,
            force + imu.force_bias,
            force_mean,
            turn,
            turn_mean,
            lambda: prepared.kept.get("covered", (imu.delay, law.clocks), lambda: self._covered(prepared, imu, law)),
            prepared.kept.get("testable", None, lambda: self.testable(prepared.flight)),
            kinematics(prepared, imu),
        )

    def testable(self, flight: Flight) -> dict[str, str | None]:
        """For each of fx fy fz tx ty tz None, or why nothing can be said about it."""
        # A centre of mass beside the point that is measured moves with every turn.
        turning = ("rate",) if any((*self.vehicle.center_of_mass, *self.vehicle.measured_at)) else ()
        needs = {"f": ("mass", "specific force", *turning), "t": ("inertia", "rate")}
        reasons = {}
        for axis in AXES:
            found = (missing_channel(n, self.vehicle, flight) for n in needs[axis[0]])
            reasons[axis] = next((r for r in found if r is not None), None)
        return reasons

    @cached_property
    def actuator_law(self) -> ActuatorLaw:
        """How the actuators follow their commands in this model."""
        law = ActuatorLaw.declared(self.vehicle)
        for effect in self._with("actuators"):
            law = effect.actuators(law)
        return law

    @cached_property
    def air_law(self) -> AirLaw:
        """The air of this model."""
        law = AirLaw.still()
        for effect in self._with("air"):
            law = effect.air(law)
        moved = [e.moved_rotor() for e in self._moved]
        return replace(law, moved=tuple(m for m in moved if m is not None))

    @cached_property
    def _moved(self) -> list[Effect]:
        """What moves rotors, where something meets the air there and damps turns by that."""
        return self._with("moved_rotor") if any(e.damps_turns for e in self._acting) else []

    @cached_property
    def _flown(self) -> Hashable:
        """What actuators and air follow from, to look up what they make."""
        return self._key("actuators", "air"), tuple(e.key for e in self._moved)

    @cached_property
    def body_law(self) -> BodyLaw:
        """The rigid body of this model. InputError where its effects leave no physical one."""
        law = BodyLaw.declared(self.vehicle)
        for effect in self._with("body"):
            law = effect.body(law)
        if law.mass is not None and law.mass <= 0:
            raise InputError(
                problem(f"{self.vehicle.name}: mass {law.mass:g} kg", "more than 0", "Correct mass_offset.")
            )
        if law.inertia is not None and np.linalg.eigvalsh(law.inertia)[0] <= 0:
            raise InputError(
                problem(f"{self.vehicle.name}: an inertia that is not positive", "a physical one", "Correct it.")
            )
        return law

    @cached_property
    def imu_law(self) -> ImuLaw:
        """What the IMU measures in this model."""
        law = ImuLaw.ideal()
        for effect in self._with("imu"):
            law = effect.imu(law)
        return law

    def _key(self, *hooks: str) -> Hashable:
        if hooks not in self._keys:
            self._keys[hooks] = tuple(e.key for e in self._acting if any(overrides(e, h) for h in hooks))
        return self._keys[hooks]

    def _with(self, hook: str) -> list[Effect]:
        if hook not in self._by_hook:
            self._by_hook[hook] = [e for e in self._acting if overrides(e, hook)]
        return self._by_hook[hook]

    def _segment(
        self, prepared: Prepared, segment: Segment, along: Along, imu: ImuLaw, law: ActuatorLaw, frame: BodyLaw
    ):
        """Specific force, its mean, angular acceleration, its mean at the segment's rows, each (rows, 3)."""
        line, kept = segment.line, prepared.kept_of_segments
        base_key = (self._flown, imu.of_rates, law.clocks)
        thrust_key = (base_key, self._key("thrust_factor", "thrust_loss", "reaction_factor"))
        thrust, total = kept.get(
            f"thrust {segment.start}", thrust_key, partial(self._thrust, along, prepared, segment.start, base_key)
        )
        along = copy.copy(along)
        object.__setattr__(along, "thrust", thrust)
        object.__setattr__(along, "of_flight", partial(prepared.of_flight, imu))
        total = total.copy()
        for number, effect in enumerate(self._with("wrench") + self._with("rotor_force")):
            # Several effects of one name, of one rotor each, have a place each: one does not push out the others.
            stage = f"{effect.name} {number if effect.repeatable else ''} {segment.start}"
            total += kept.get(stage, (thrust_key, effect.key), partial(_added, effect, along))
        force, torque = total[:, :3], total[:, 3:]
        momenta = [
            kept.get(f"momentum {e.name} {segment.start}", (thrust_key, e.key), partial(e.rotor_momentum, along))
            for e in self._with("rotor_momentum")
        ]
        inertia, rate = frame.inertia, along.motion.rate
        unknown = np.full_like(force, np.nan)
        momentum = sum((m[0] for m in momenta), np.zeros(3))
        if momenta and rate is not None:
            torque = torque - body.cross(rate, momentum)
        angular = unknown
        spin_up = slope = None
        if inertia is not None and rate is not None:
            angular = body.angular_acceleration(frame, force, torque, rate)
            if momenta:
                slope = sum((m[1] for m in momenta), np.zeros(3))
                spin_up = self._spin_up(line, momentum, slope, inertia, imu.lag)
        elif rate is not None and (frame.center_of_mass.any() or frame.measured_at.any()):
            angular = prepared.angular_acceleration(segment, imu, law)
        turn, predicted = angular, ~prepared.turned
        if not predicted.all() and rate is not None and (frame.center_of_mass.any() or frame.measured_at.any()):
            turn = np.where(predicted, angular, prepared.angular_acceleration(segment, imu, law))
        f = body.specific_force(frame, force, rate, turn) if frame.mass is not None else unknown
        loads = [e.load(along) for e in self._with("load")]
        if loads and frame.mass is not None:
            free = f
            if slope is not None and inertia is not None and frame.center_of_mass.any():
                free = f - body.cross(-slope @ np.linalg.inv(inertia) * predicted, frame.center_of_mass)
            for load, pull in zip(loads, body.pulls(frame, loads, free), strict=True):
                df, dw = body.response_to_force(frame, load.direction)
                if not predicted.all() and frame.center_of_mass.any():
                    df = df + body.cross(dw * ~predicted, frame.center_of_mass)  # the recorded turn holds its share
                f, angular = f + pull[:, None] * df, angular + pull[:, None] * dw
                turn = turn + pull[:, None] * dw * predicted
        if frame.measured_at.any():
            f = f + body.lever(frame.measured_at, rate, turn)
        if inertia is None or rate is None:
            angular = unknown
        result = [line.at_rows(f), line.means(f), line.at_rows(angular), line.means(angular)]
        if imu.lag > 0.0:
            result += [line.forcing(f), line.forcing(angular)]
        if spin_up is not None:
            for of_force, of_turn, more in zip((0, 1, 4), (2, 3, 5), spin_up, strict=False):
                # The point that is measured, from the centre of mass, which it turns about.
                if (arm := frame.measured_at - frame.center_of_mass).any():
                    result[of_force] = result[of_force] + body.cross(more * predicted, arm)
                result[of_turn] = result[of_turn] + more
        return result

    def _thrust(self, along: Along, prepared: Prepared, start: int, key: Hashable) -> tuple[Array, Array]:
        """Thrust (N, rotors) after all factors and losses, and the wrench (N, 6) that the inputs make by it.

        start, key: of the segment, and of what moves its rotors.
        """
        steady: Array | float = 1.0  # of each rotor, all along the flight
        changing: Array | None = None
        for number, effect in enumerate(self._with("thrust_factor")):
            stage = f"factor {effect.name} {number if effect.repeatable else ''} {start}"
            made = partial(effect.thrust_factor, along)
            factor = np.asarray(prepared.kept_of_segments.get(stage, (key, effect.key), made))
            if factor.ndim < 2:
                steady = steady * factor
            else:
                changing = factor if changing is None else changing * factor
        thrust = along.nominal_thrust * steady
        if changing is not None:
            thrust *= changing
        for effect in self._with("thrust_loss"):
            thrust = thrust - effect.thrust_loss(along)
        ratio = prepared.wrench.ratio
        for effect in self._with("reaction_factor"):
            ratio = ratio * effect.reaction_factor(along)
        return thrust, prepared.wrench(thrust, ratio, along.actuation)

    def _spin_up(self, line, momentum: Array, slope: Array, inertia: Array, lag: float) -> tuple[Array, ...]:
        """Angular acceleration by -dH/dt at the rows, and its mean over each step: the change of H, exactly.

        Where the sensors are filtered, also what the filter takes up of it: what the nodes miss is spread evenly.
        """
        inverse = np.linalg.inv(inertia)
        at_rows = line.at_rows(momentum)
        time = line.time[line.row]
        mean = np.full_like(at_rows, np.nan)
        mean[:-1] = -np.diff(at_rows, axis=0) / np.diff(time)[:, None]
        mean = mean @ inverse
        if lag == 0.0:
            return -line.at_rows(slope) @ inverse, mean
        spread = -np.expm1(-np.append(np.diff(time), 0.0) / lag)[:, None]
        turning = -slope @ inverse
        return line.at_rows(turning), mean, line.forcing(turning) + spread * (mean - line.means(turning))

    def _check_channels(self, flight: Flight) -> None:
        for effect in self._acting:
            reason = effect.missing(self.vehicle, flight)
            if reason is not None:
                source = flight.meta.get("source", "flight")
                raise InputError(
                    problem(
                        f"{source}: {effect.name} cannot be evaluated: {reason}",
                        "the channels that the model's effects need",
                        "Add them or use a model without it.",
                    )
                )

    def _covered(self, prepared: Prepared, imu: ImuLaw, law: ActuatorLaw) -> Mask:
        r = prepared.recorded
        t = r.t - imu.delay
        good = np.ones(len(t), dtype=bool)
        for samples, commanded in ((r.rotor, r.rotor_commanded), (r.tilt, r.tilt_commanded)):
            if not commanded:
                good &= _between_samples(t - law.late + law.telemetry, samples)
                continue
            given = t - law.delay - law.late
            # Of a wrench or of tilts a channel may have none of its own: of rotors each does.
            each = samples.given if samples is r.rotor and self.vehicle.rotors else (samples.times,)
            for times in each:
                latest = np.clip(np.searchsorted(times, given, side="right") - 1, 0, None)
                good &= np.abs(given - times[latest]) <= max(_STALE * samples.usual, _STALE_AT_LEAST)
        for moved in (r.attitude, r.velocity, r.rate):
            if moved is not None:
                good &= _between_samples(t, moved)
        return good


def _between_samples(t: Array, samples: Samples) -> Mask:
    """Where t (n,) lies between two samples that are not too far apart, (n,) bool."""
    if len(samples.times) < 2:
        return np.ones(len(t), dtype=bool)
    after = np.clip(np.searchsorted(samples.times, t), 1, len(samples.times) - 1)
    hole = samples.times[after] - samples.times[after - 1]
    outside = (t < samples.times[0] - 1e-9) | (t > samples.times[-1] + 1e-9)
    return (hole <= max(_STALE * samples.usual, _STALE_AT_LEAST)) & ~outside


def _added(effect: Effect, along: Along) -> Array:
    if not overrides(effect, "rotor_force"):
        return effect.wrench(along)
    at_rotors = forces_at_rotors(along.met_position, effect.rotor_force(along))
    return at_rotors + effect.wrench(along) if overrides(effect, "wrench") else at_rotors
