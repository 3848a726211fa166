"""A flight made ready for many predictions: what does not change from one to the next is kept."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from infotraj import rotations
from infotraj.effects.along import Actuation, Along, Motion, OriginPath
from infotraj.effects.laws import ActuatorLaw, ImuLaw
from infotraj.flight import Flight
from infotraj.models.actuation import actuation
from infotraj.models.interpolation import interpolate
from infotraj.models.recorded import Recorded, Samples, recorded
from infotraj.models.timeline import Timeline, timeline
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

T = TypeVar("T")
SEGMENT = 4096  # rows evaluated at once, so that memory does not grow with the flight
_KEPT_ROWS = 40_000  # results are kept for this many rows at each stage, whatever the number of flights


class Kept:
    """The last few results of each stage by key."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._stages: dict[str, OrderedDict[Hashable, Any]] = {}

    def get(self, stage: str, key: Hashable, make: Callable[[], T]) -> T:
        """The result of `make` for this key, made once."""
        held = self._stages.setdefault(stage, OrderedDict())
        if key in held:
            held.move_to_end(key)
            return held[key]
        value = make()
        held[key] = value
        while len(held) > self._most:
            held.popitem(last=False)
        return value


@dataclass(frozen=True)
class Segment:
    """A stretch of rows start..stop (the row after the last one included for the mean), and its own instants."""

    start: int
    stop: int
    line: Timeline


class Prepared:
    """A flight with a vehicle: recorded channels, and results that several predictions share."""

    def __init__(self, vehicle: Vehicle, flight: Flight) -> None:
        self.vehicle = vehicle
        self.flight = flight
        self.recorded: Recorded = recorded(vehicle, flight)
        self.start = float(self.recorded.t[0])
        rows = len(self.recorded.t)
        self.kept = Kept(max(2, min(6, _KEPT_ROWS // rows)))

    def segments(self, imu_delay: float, command_delay: float) -> list[Segment]:
        """The rows in stretches, sampled `imu_delay` (s) before their time, commands acting `command_delay` later."""
        return self.kept.get("segments", (imu_delay, command_delay), lambda: self._segments(imu_delay, command_delay))

    def along(self, segment: Segment, imu: ImuLaw, law: ActuatorLaw, imu_key: Hashable, law_key: Hashable) -> Along:
        """Motion and actuators at the segment's instants."""

        def make() -> Along:
            motion = self.kept.get(
                f"motion {segment.start}",
                (segment.start, imu_key, law.delay),
                lambda: self.motion(segment.line.time, imu),
            )
            actuators = self.kept.get(
                f"actuators {segment.start}",
                (imu.delay, law_key),
                lambda: self._cut(segment, imu, law, law_key),
            )
            return Along(self.vehicle, motion, actuators, lambda key, fn: self._of_flight(key, imu, imu_key, fn))

        return self.kept.get(f"along {segment.start}", (imu_key, law_key), make)

    def motion(self, time: Array, imu: ImuLaw) -> Motion:
        """Recorded motion at `time` (N,) s of the flight's clock, rates corrected for what the IMU law says."""
        r = self.recorded
        attitude = None
        if r.attitude is not None:
            attitude = rotations.matrix(rotations.normalize(_at(r.attitude, time)))
        velocity = None
        if r.velocity is not None and attitude is not None:
            velocity = np.einsum("nji,nj->ni", attitude, _at(r.velocity, time))
        rate = self.true_rate(imu)
        return Motion(
            time - self.start,
            attitude,
            _at(r.position, time)[:, 2] if r.position is not None else None,
            velocity,
            _at(rate, time) if rate is not None else None,
            _at(r.battery, time)[:, 0] if r.battery is not None else None,
        )

    def true_rate(self, imu: ImuLaw) -> Samples | None:
        """The body's rates and when they were sampled, from the measured ones; derived ones as they are."""
        rate = self.recorded.rate
        if rate is None or rate.derived:
            return rate
        return Samples(rate.times - imu.delay, (rate.values - imu.rate_bias) @ imu.rotation)

    def true_specific_force(self, imu: ImuLaw) -> Samples | None:
        """The specific force (m/s^2, body) of the origin and when it was sampled, from the measured one."""
        force = self.recorded.specific_force
        if force is None or force.derived:
            return force
        return Samples(force.times - imu.delay, force.values @ imu.rotation)

    def angular_acceleration(self, time: Array, imu: ImuLaw) -> Array | None:
        """Recorded angular acceleration (N, 3), rad/s^2, by central differences of the rates."""
        rate = self.true_rate(imu)
        if rate is None:
            return None
        return interpolate(rate.times, np.gradient(rate.values, rate.times, axis=0), time)

    def origin_path(self, imu: ImuLaw) -> OriginPath | None:
        """The specific force of the body's origin in world axes, sample by sample; from the velocity where needed."""
        r = self.recorded
        force = self.true_specific_force(imu)
        if r.attitude is not None and force is not None:
            times = force.times
            world = rotations.to_world(rotations.normalize(_at(r.attitude, times)), force.values)
        elif r.velocity is not None:
            times, up = r.velocity.times, np.array([0.0, 0.0, self.vehicle.gravity])
            world = np.gradient(r.velocity.values, times, axis=0) + up
        else:
            return None
        return OriginPath(
            times[0] - self.start, times[-1] - self.start, partial(interpolate, times - self.start, world)
        )

    def _of_flight(self, key: Hashable, imu: ImuLaw, imu_key: Hashable, make: Callable[[OriginPath], T]) -> T:
        return self.kept.get("of flight", (key, imu_key), lambda: make(self.origin_path(imu)))

    def _segments(self, imu_delay: float, command_delay: float) -> list[Segment]:
        t = self.recorded.t - imu_delay
        r = self.recorded
        commands = [s.times for s, given in ((r.rotor, r.rotor_commanded), (r.tilt, r.tilt_commanded)) if given]
        jumps = np.unique(np.concatenate(commands)) + command_delay if commands else np.zeros(0)
        found = []
        for start in range(0, max(len(t) - 1, 1), SEGMENT):
            stop = min(start + SEGMENT + 1, len(t))
            found.append(Segment(start, stop, timeline(t[start:stop], jumps)))
        return found

    def _cut(self, segment: Segment, imu: ImuLaw, law: ActuatorLaw, law_key: Hashable) -> Actuation:
        segments = self.segments(imu.delay, law.delay)
        if len(segments) == 1:
            return actuation(self.recorded, law, segment.line.time)

        def whole() -> list[Actuation]:
            lines = [s.line.time for s in segments]
            all_of_it = actuation(self.recorded, law, np.concatenate(lines))
            ends = np.cumsum([0, *(len(line) for line in lines)])
            names = ("rotor", "rotor_slope", "tilt", "tilt_slope")
            return [Actuation(*(getattr(all_of_it, name)[a:b] for name in names)) for a, b in pairwise(ends)]

        parts = self.kept.get("actuators of flight", (imu.delay, law_key), whole)
        return parts[[s.start for s in segments].index(segment.start)]


def _at(samples: Samples, time: Array) -> Array:
    return interpolate(samples.times, samples.values, time)
