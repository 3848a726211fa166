"""A flight made ready for many predictions: what does not change from one to the next is kept."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from infotraj import rotation_matrices, rotations
from infotraj.dynamics.inputs import for_vehicle
from infotraj.effects.along import Actuation, Along, Motion, OriginPath
from infotraj.effects.channels import from_velocity
from infotraj.effects.laws import ActuatorLaw, AirLaw, ImuLaw
from infotraj.flight import BEGAN, TURNED, Flight
from infotraj.models.actuation import rotors_at, tilts_at
from infotraj.models.interpolation import interpolate
from infotraj.models.origin_path import origin_path
from infotraj.models.quieted import quieted
from infotraj.models.recorded import Recorded, Samples, recorded
from infotraj.models.rotor_wrench import wrench_of_inputs
from infotraj.models.sensor_lag import slope
from infotraj.models.timeline import Timeline, timeline
from infotraj.rotations import Array, Mask
from infotraj.vehicle import Vehicle

T = TypeVar("T")
_BESIDE = 64  # samples beside a segment that interpolation may look at, enough to know their usual interval
SEGMENT = 8192  # rows evaluated at once, so that memory does not grow with the flight
_BEFORE = 1.5  # s beside the rows that are asked for: what acts has settled within it, and so far is looked back
_KEPT_ROWS = 80_000  # of a longer flight nothing is kept that grows with rotors and rows


class Kept:
    """The last few results of each stage by key; with `most` 0 none."""

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
    """A flight, as its vehicle reads it, with that vehicle: recorded channels, and what several predictions share.

    coarse: predictions are means of fewer points (`timeline`); quiet: what the IMU says of recorded steps is without
    its noise (`quieted`); both for how a prediction changes. followed (3,): m, the point whose path is recorded, from
    the body's origin; with an accelerometer the origin, whatever the place of that. asked (n,): the rows of which
    predictions are asked, all where None; of others they say nothing (NaN), and actuators and clocks run on over them.
    turned (3,): body axes about which the flight's metadata say that turns are as recorded: no torque about them is
    believed, and a point beside the origin is accelerated by the turn that was measured.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        flight: Flight,
        coarse: bool = False,
        quiet: bool = False,
        asked: Mask | None = None,
    ) -> None:
        self.vehicle, self.coarse, self.quiet = vehicle, coarse, quiet
        self.flight = for_vehicle(flight, vehicle)
        self.recorded: Recorded = recorded(vehicle, self.flight)
        self.asked = asked
        self.turned = np.array(self.flight.meta.get(TURNED, (False, False, False)))
        self.wrench = wrench_of_inputs(vehicle)
        force = self.recorded.specific_force
        self.followed = np.array(vehicle.measured_at) * float(force is None or force.derived)
        self.start = float(self.flight.meta.get(BEGAN, self.recorded.t[0]))
        rows = sum(stop - start for start, stop in self._stretches())
        self.kept = Kept(max(2, min(6, _KEPT_ROWS // rows)))
        self.kept_of_segments = Kept(min(6, _KEPT_ROWS // rows))

    def part(self, asked: Mask, airborne: Mask) -> Prepared:
        """The flight from a little before the vehicle is in the air to a little after the last of the rows asked for.

        asked, airborne: (n,). What is recorded of the rest costs time and says nothing. The clock of effects begins
        where the log does, and a load that hangs from the vehicle swings since it is in the air.
        """
        flying = np.flatnonzero(airborne | asked)
        first, last = _around(self.recorded.t, flying[flying <= np.flatnonzero(asked)[-1]])
        flight = self.flight
        table = flight.table.assign(airborne=airborne.astype(float))[first:last].reset_index(drop=True)
        for name in table.columns[table.iloc[0].isna()]:
            if name.startswith("cmd_") or name == "battery":
                known = flight.table[name][:first].dropna()  # what was commanded last still acts
                table.loc[0, name] = known.iloc[-1] if len(known) else np.nan
        return self.of(flight=Flight(table, {**flight.meta, BEGAN: self.start}), asked=asked[first:last])

    def of(self, **changes: Any) -> Prepared:
        """The flight prepared anew with these arguments, and all others as they are."""
        own = {name: getattr(self, name) for name in ("vehicle", "flight", "coarse", "quiet", "asked")}
        return Prepared(**own | changes)

    def turning(self, turned: tuple[bool, ...]) -> Prepared:
        """The same with `turned` (3,)."""
        return self.of(flight=Flight(self.flight.table, {**self.flight.meta, TURNED: turned}))

    def as_logged(self, law: ActuatorLaw, imu: ImuLaw) -> tuple[ActuatorLaw, ImuLaw]:
        """The laws on this log's clocks: without an accelerometer all of the motion has one, and may be late itself."""
        force = self.recorded.specific_force
        if imu.delay == 0.0 or not (force is None or force.derived):
            return law, imu
        return replace(law, late=law.late + imu.delay), replace(imu, delay=0.0)

    def segments(self, imu: ImuLaw, law: ActuatorLaw) -> list[Segment]:
        """The rows in stretches, sampled as early as the IMU was, commands acting as late as `law` says."""
        return self.kept.get(
            "segments", (imu.delay, imu.lag, law.clocks), lambda: self._segments(imu, law.delay + law.late)
        )

    def along(self, segment: Segment, imu: ImuLaw, law: ActuatorLaw, air: AirLaw, others: Hashable) -> Along:
        """Motion, actuators and air at the segment's instants; `others` is the key of the laws beside the IMU's."""

        def make() -> Along:
            time, instants = segment.line.time, (imu.delay, imu.lag > 0.0, law.clocks)
            pose = self.kept_of_segments.get(f"pose {segment.start}", instants, lambda: self._pose(time))
            attitude, height, velocity, battery = pose
            rate, turning = self.measured("rate", imu), None
            if rate is not None:
                stage, key = f"turning {segment.start}", (imu.lag, instants)
                turning = self.kept_of_segments.get(stage, key, lambda: _at(rate, time))
                turning = turning if rate.derived else imu.true(turning, imu.rate_bias)
            motion = Motion(time - self.start, attitude, height, velocity, turning, battery)
            actuators = self._actuators(segment, imu, law)
            return Along(self.vehicle, motion, actuators, air=air)

        return self.kept_of_segments.get(f"along {segment.start}", (imu.of_rates, law.clocks, others), make)

    def _pose(self, time: Array) -> tuple[Array | None, ...]:
        """Attitude, height, velocity in body axes and voltage at `time` (N,) s of the flight's clock."""
        r = self.recorded
        attitude = height = velocity = None
        if r.attitude is not None:
            attitude = rotation_matrices.matrices(rotations.normalize(_at(r.attitude, time)))
        if r.velocity is not None and attitude is not None:
            velocity = rotation_matrices.turned_back(attitude, _at(r.velocity, time))
        if r.position is not None:
            height = _at(Samples(r.position.times, r.position.values[:, 2:]), time)[:, 0]
        battery = _at(r.battery, time)[:, 0] if r.battery is not None else None
        if self.followed.any() and attitude is not None:
            if velocity is not None and r.rate is not None:
                velocity = velocity - np.cross(_at(r.rate, time), self.followed)
            if height is not None:
                height = height - attitude[:, 2] @ self.followed
        return attitude, height, velocity, battery

    def measured(self, name: str, imu: ImuLaw, cut: float = np.inf) -> Samples | None:
        """What the IMU measured, "rate" or "force", before its filter, and when; derived channels as they are.

        cut: Hz, from which on it is left out (`quieted`).
        """
        samples = {"rate": self.recorded.rate, "force": self.recorded.specific_force}[name]
        if samples is None or samples.derived:
            return samples

        def made() -> Samples:
            values = samples.values
            if imu.lag > 0.0:
                values = values + imu.lag * self.kept.get(f"slope of {name}", None, lambda: slope(samples))
            return quieted(Samples(samples.times - imu.delay, values), cut)

        return self.kept.get(f"{name} before the filter", (imu.delay, imu.lag, cut), made)

    def true_rate(self, imu: ImuLaw) -> Samples | None:
        """The body's rates and when they were sampled, from the measured ones; derived ones as they are."""
        rate = self.measured("rate", imu)
        return rate if rate is None or rate.derived else Samples(rate.times, imu.true(rate.values, imu.rate_bias))

    def true_specific_force(self, imu: ImuLaw) -> Samples | None:
        """The specific force (m/s^2, body) of the origin and when it was sampled, from the measured one."""
        force = self.measured("force", imu)
        return force if force is None or force.derived else Samples(force.times, imu.true(force.values, imu.force_bias))

    def angular_acceleration(self, segment: Segment, imu: ImuLaw, law: ActuatorLaw) -> Array:
        """Recorded angular acceleration (N, 3), rad/s^2, at the segment's instants, by central differences of the
        rates, which the flight has."""

        def made() -> Array:
            rate = self.measured("rate", imu)
            assert rate is not None
            found = interpolate(rate.times, rate.slopes, segment.line.time, rate.usual)
            return found if rate.derived else imu.true(found, np.zeros(3))

        key = (imu.delay, imu.lag, imu.rotation.tobytes(), law.clocks)
        return self.kept_of_segments.get(f"angular acceleration {segment.start}", key, made)

    def origin_path(self, imu: ImuLaw) -> OriginPath | None:
        """The specific force of the body's origin in world axes, sample by sample; from the velocity where needed."""
        force = None if from_velocity(self.flight) else self.true_specific_force(imu)
        return origin_path(self.vehicle, self.recorded, force, self.start)

    def of_flight(self, imu: ImuLaw, key: Hashable, make: Callable[[OriginPath], T]) -> T:
        """What follows from the path of the whole flight, made once for this key and IMU."""

        def made() -> T:
            path = self.kept.get("path", imu.of_force, lambda: self.origin_path(imu))
            assert path is not None  # an effect that asks for it needs the channels that it is made of
            return make(path)

        return self.kept.get("of flight", (key, imu.of_force), made)

    def _segments(self, imu: ImuLaw, command_delay: float) -> list[Segment]:
        t = self.recorded.t - imu.delay
        r = self.recorded
        commands = [s.times for s, given in ((r.rotor, r.rotor_commanded), (r.tilt, r.tilt_commanded)) if given]
        jumps = np.unique(np.concatenate(commands)) + command_delay if commands else np.zeros(0)
        found = []
        for first, last in self._stretches():
            for start in range(first, max(last - 1, first + 1), SEGMENT):
                stop = min(start + SEGMENT + 1, last)
                inside = slice(*np.searchsorted(jumps, [t[start], t[stop - 1]]))
                found.append(Segment(start, stop, timeline(t[start:stop], jumps[inside], imu.lag, self.coarse)))
        return found

    def _stretches(self) -> list[tuple[int, int]]:
        """First row, and the one after the last, of each stretch that holds rows which are asked for."""
        t = self.recorded.t
        if self.asked is None or not self.asked.any():
            return [(0, len(t))]
        rows = np.flatnonzero(self.asked)
        parts = np.split(rows, np.flatnonzero(np.diff(t[rows]) > 2.0 * _BEFORE) + 1)
        return [_around(t, part) for part in parts]

    def _actuators(self, segment: Segment, imu: ImuLaw, law: ActuatorLaw) -> Actuation:
        """The part of the flight's actuators that belongs to the segment."""
        r, segments = self.recorded, self.segments(imu, law)

        def over_flight(response: Callable[[Array], tuple[Array, Array]]) -> list[tuple[Array, Array]]:
            values, slopes = response(np.concatenate([s.line.time for s in segments]))
            ends = np.cumsum([0, *(len(s.line.time) for s in segments)])
            return [(values[a:b], slopes[a:b]) for a, b in pairwise(ends)]

        times = (imu.delay, imu.lag > 0.0, law.clocks)
        rotor_key = (*times, law.rotor_time_constant.tobytes())
        rotor = self.kept.get("rotors", rotor_key, lambda: over_flight(partial(rotors_at, r, law)))
        tilt_key = (*times, *(x.tobytes() for x in (law.tilt_time_constant, law.tilt_max_rate, law.tilt_play)))
        tilt = self.kept.get("tilts", tilt_key, lambda: over_flight(partial(tilts_at, r, law)))
        here = next(i for i, s in enumerate(segments) if s.start == segment.start)
        return self.kept_of_segments.get(
            f"actuators {segment.start}",
            (rotor_key, tilt_key, law.tilt_bias.tobytes()),
            lambda: Actuation(*rotor[here], tilt[here][0] + law.tilt_bias, tilt[here][1]),
        )


def _at(samples: Samples, time: Array) -> Array:
    # Only the samples around these instants are looked at: a long flight costs no more a row than a short one.
    first, last = np.searchsorted(samples.times, [time[0], time[-1]])
    near = slice(max(first - _BESIDE, 0), last + _BESIDE)
    return interpolate(samples.times[near], samples.values[near], time, samples.usual)


def _around(t: Array, rows: NDArray) -> tuple[int, int]:
    """First row, and the one after the last, of the stretch with these rows (m,) and what lies a little beside them."""
    there = t[rows]
    first = np.searchsorted(t, there[0] - _BEFORE)
    return int(first), int(np.searchsorted(t, there[-1] + _BEFORE, side="right"))
