"""Rollouts: open loop from every recorded state with recorded inputs, and how far they are off after so long.

The measure is that of the multi-horizon benchmark for nano-quadrotors (Busetto et al. 2025, arXiv 2512.14450): the
mean, over all starts, of the Euclidean error of position, velocity and rate and of the geodesic error of attitude.
Actuators are not started anew: they stand where the commands since the flight's first row have brought them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from infotraj import rotations
from infotraj.checking.airborne import airborne_rows
from infotraj.comparing import integration, state_wrench
from infotraj.comparing.equation_error import SETTLING
from infotraj.comparing.window import GAP
from infotraj.errors import UsageError, problem
from infotraj.flight import Flight
from infotraj.models import Model, body
from infotraj.models.interpolation import interpolate
from infotraj.models.prepared import Prepared
from infotraj.rotations import Array

MEASURES = ("position", "velocity", "attitude", "rate")
UNITS = {"position": "m", "velocity": "m/s", "attitude": "rad", "rate": "rad/s"}
CHUNK = 4096  # rows whose wrench is held at once, so that memory does not grow with the horizon or the flight
_JUST_AFTER = 1e-6  # share of an interval after a command's own instant, at which the command acts already


@dataclass(frozen=True)
class Horizon:
    """How long a rollout runs: a number of steps, or seconds; `label` as it was typed."""

    label: str
    steps: int | None = None
    seconds: float = 0.0


@dataclass(frozen=True)
class Rollouts:
    """Errors of all rollouts of one flight.

    t (s,): the starts (s); errors (s, h, 4): of position (m), velocity (m/s), attitude (rad), rate (rad/s) after each
    horizon, NaN where the flight does not go on that long without a gap or in the air; horizons (h,). order: of the
    integrator. reason: why there is none, where there is none.
    """

    t: Array
    errors: Array
    horizons: tuple[Horizon, ...]
    order: int = integration.ORDER
    reason: str | None = None

    @property
    def starts(self) -> NDArray[np.int_]:
        """How many starts reach each horizon, (h,)."""
        return np.isfinite(self.errors[..., 0]).sum(axis=0)


def parse_horizons(text: str) -> tuple[Horizon, ...]:
    """Horizons from "1,10,0.5s": steps, or seconds. UsageError for anything else."""
    found = []
    for part in (p.strip() for p in text.split(",")):
        if re.fullmatch(r"[1-9]\d*", part):
            found.append(Horizon(part, steps=int(part)))
        elif re.fullmatch(r"\d+(\.\d*)?s|\.\d+s", part) and float(part[:-1]) > 0:
            found.append(Horizon(part, seconds=float(part[:-1])))
        else:
            raise UsageError(problem(f"horizon '{part}'", "steps or seconds, such as 1,10,0.5s", "Correct --horizons."))
    return tuple(found)


def rollouts(
    model: Model,
    flight: Flight,
    horizons: Sequence[Horizon],
    *,
    start: float | None = None,
    stop: float | None = None,
    substeps: int = 1,
) -> Rollouts:
    """Rolls the model out from every recorded state of a flight.

    start, stop: s, the part in which rollouts start and end. substeps: intervals of the integrator between two rows.
    A vehicle without mass or inertia, or a flight without pose, has no rollouts: `reason` says so. InputError where the
    commands that the vehicle needs are missing.
    """
    horizons = tuple(horizons)
    prepared = Prepared(model.vehicle, flight)
    flight = prepared.flight
    reason = _cannot(model, prepared)
    if reason is not None:
        return Rollouts(np.zeros(0), np.zeros((0, len(horizons), 4)), horizons, reason=reason)
    t = flight.t
    states = _states(model, prepared)
    ok = _usable(flight, model, start, stop)
    ends = _ends(t, ok, np.all(np.isfinite(states), axis=1), horizons)
    starts = np.flatnonzero((ends >= 0).any(axis=1))
    errors = np.full((len(starts), len(horizons), 4), np.nan)
    if len(starts):
        grid = _grid(t, substeps)
        inputs = state_wrench.instants(model, prepared, grid.ravel())
        active = state_wrench.active_features(model, inputs)
        for part in np.split(starts, np.flatnonzero(np.diff(starts // CHUNK)) + 1):
            reach = np.where(ends[part] >= 0, ends[part] - part[:, None], 0)
            rolled = _rolled(model, inputs, active, grid, states, part, reach * substeps, substeps)
            errors[np.searchsorted(starts, part)] = _errors(rolled, states, np.where(reach > 0, ends[part], -1))
    return Rollouts(t[starts], errors, horizons)


def mean_errors(found: Sequence[Rollouts]) -> dict[str, dict[str, float | None]]:
    """measure -> horizon as typed -> mean over all starts of all flights (None where no start reaches it)."""
    result: dict[str, dict[str, float | None]] = {}
    for m, measure in enumerate(MEASURES):
        result[measure] = {}
        for h, horizon in enumerate(found[0].horizons):
            values = np.concatenate([f.errors[:, h, m] for f in found])
            values = values[np.isfinite(values)]
            result[measure][horizon.label] = float(values.mean()) if len(values) else None
    return result


def _cannot(model: Model, prepared: Prepared) -> str | None:
    law, r = model.body_law, prepared.recorded
    for missing, what in (
        (law.mass is None, "the vehicle file gives no mass"),
        (law.inertia is None, "the vehicle file gives no inertia"),
        (r.position is None, "the flight has no position"),
        (r.attitude is None, "the flight has no attitude"),
        (r.velocity is None, "the flight has no velocity"),
        (r.rate is None, "the flight has no rates"),
    ):
        if missing:
            return what
    return None


def _states(model: Model, prepared: Prepared) -> Array:
    """Recorded states at the rows (n, 13), NaN in a row that lacks one.

    Streams of different rates or phases have few rows in common: at the samples of the slowest the others are
    interpolated, where they have neighbours.
    """
    r, imu = prepared.recorded, prepared.as_logged(model.actuator_law, model.imu_law)[1]
    out = np.full((len(r.t), 13), np.nan)
    true_rate = prepared.true_rate(imu)
    assert r.position is not None  # this and the others: see `_cannot`
    assert r.velocity is not None
    assert r.attitude is not None
    assert r.rate is not None
    assert true_rate is not None
    rate = r.rate.values if r.rate.derived else true_rate.values
    slowest = min((r.position, r.velocity, r.attitude, r.rate), key=lambda samples: len(samples.times)).times
    for columns, samples, values in (
        (slice(0, 3), r.position, r.position.values),
        (slice(3, 6), r.velocity, r.velocity.values),
        (slice(6, 10), r.attitude, r.attitude.values),
        (slice(10, 13), r.rate, rate),
    ):
        out[np.searchsorted(r.t, samples.times), columns] = values
        after = np.clip(np.searchsorted(samples.times, slowest), 1, len(samples.times) - 1)
        step = np.diff(samples.times)
        between = (
            (step[after - 1] < GAP * np.median(step)) & (slowest > samples.times[0]) & (slowest < samples.times[-1])
        )
        rows = np.searchsorted(r.t, slowest[between])
        missing = np.isnan(out[rows, columns]).any(axis=1)
        found = interpolate(samples.times, values, slowest[between][missing])
        out[rows[missing], columns] = rotations.normalize(found) if samples is r.attitude else found
    if prepared.followed.any():
        # The states are the origin's.
        whole = np.isfinite(out).all(axis=1)
        turned = rotations.matrix(rotations.normalize(out[whole, 6:10]))
        out[whole, :3] -= turned @ prepared.followed
        out[whole, 3:6] -= np.einsum("nij,nj->ni", turned, np.cross(out[whole, 10:], prepared.followed))
    return out


def _usable(flight: Flight, model: Model, start: float | None, stop: float | None) -> NDArray[np.bool_]:
    t = flight.t
    inside = (t >= (start if start is not None else -np.inf)) & (t < (stop if stop is not None else np.inf))
    return inside & (t >= t[0] + SETTLING) & airborne_rows(flight, model.vehicle).rows


def _ends(t: Array, ok: NDArray, known: NDArray, horizons: Sequence[Horizon]) -> NDArray:
    """Row at which each horizon ends for a start in each row, (n, h); -1 where it cannot be reached."""
    n = len(t)
    step = np.diff(t)
    broken = np.concatenate([[0], np.cumsum((step > GAP * np.median(step)) | ~ok[1:] | ~ok[:-1])])
    ends = np.full((n, len(horizons)), -1)
    rows = np.arange(n)
    states = np.flatnonzero(known)
    for h, horizon in enumerate(horizons):
        if horizon.steps is not None:
            # A step leads to the next row that holds a state: of a held stream most rows hold none.
            end = np.append(states, np.full(horizon.steps + 1, n))[np.searchsorted(states, rows) + horizon.steps]
            reached = np.ones(n, dtype=bool)
        else:
            wanted = t + horizon.seconds
            after = np.clip(np.searchsorted(t, wanted), 1, n - 1)
            end = np.where(wanted - t[after - 1] < t[after] - wanted, after - 1, after)
            reached = np.abs(t[end] - wanted) <= 0.5 * np.median(step) * 1.001
        inside = (end < n) & (end > rows)
        end = np.where(inside, end, 0)
        good = inside & reached & known & known[end] & ok & (broken[end] == broken)
        ends[good, h] = end[good]
    return ends


def _grid(t: Array, substeps: int) -> Array:
    """Instants (intervals, 3) s just after the beginning, in the middle and at the end of every interval."""
    share = np.arange(substeps + 1) / substeps
    edges = np.append((t[:-1, None] + np.diff(t)[:, None] * share[:-1]).ravel(), t[-1])
    step = np.diff(edges)
    return np.column_stack([edges[:-1] + _JUST_AFTER * step, edges[:-1] + 0.5 * step, edges[1:]])


def _rolled(model, inputs, active, grid, states, starts, reach, substeps) -> Array:
    """States (s, h, 13) after `reach` (s, h) intervals from rows `starts` (s,)."""
    begin, stop = starts[0] * substeps, int((starts * substeps + reach.max(axis=1)).max())
    part = inputs.part(slice(3 * begin, 3 * stop))
    first = starts * substeps - begin
    law = model.body_law
    step = (grid[begin:stop, 2] - grid[begin:stop, 0]) / (1.0 - _JUST_AFTER)
    out = np.full((*reach.shape, 13), np.nan)
    if active is not None:
        form = state_wrench.linear_form(model, part, active)
        fixed = form.fixed.reshape(len(step), 3, 6)
        parts = form.parts.reshape(len(step), 3, len(active), 6)
        integration.roll(
            first, step, fixed, parts, active, law.mass, law.inertia, np.linalg.inv(law.inertia),
            law.center_of_mass, model.vehicle.gravity, states[starts], reach, out,
        )  # fmt: skip
        return out
    return _rolled_by_state(model, law, part, first, step, states[starts], reach, out)


def _rolled_by_state(model, law, inputs, first, step, current, reach, out) -> Array:
    """The same, each wrench evaluated at its own state: for effects that are not linear in any known function of it."""
    gravity = np.array([0.0, 0.0, model.vehicle.gravity])

    def slope(x: Array, interval: NDArray, stage: int) -> Array:
        attitude = rotations.matrix(rotations.normalize(x[:, 6:10]))
        velocity = np.einsum("nji,nj->ni", attitude, x[:, 3:6])
        rate = np.ascontiguousarray(x[:, 10:])
        total = state_wrench.wrench(model, inputs.part(3 * interval + stage), x[:, 2], velocity, attitude, rate)
        angular = body.angular_acceleration(law, total[:, :3], total[:, 3:], rate)
        specific = body.specific_force(law, total[:, :3], rate, angular)
        acceleration = np.einsum("nij,nj->ni", attitude, specific) - gravity
        turn = 0.5 * rotations.multiply(x[:, 6:10], np.column_stack([np.zeros(len(x)), rate]))
        return np.concatenate([x[:, 3:6], acceleration, turn, angular], axis=1)

    current = current.copy()
    going = np.arange(len(current))
    for done in range(int(reach.max())):
        going = going[reach[going].max(axis=1) > done]
        x, i = current[going], first[going] + done
        dt = step[i][:, None]
        a = slope(x, i, 0)
        b = slope(x + 0.5 * dt * a, i, 1)
        c = slope(x + 0.5 * dt * b, i, 1)
        d = slope(x + dt * c, i, 2)
        x = x + dt / 6.0 * (a + 2.0 * (b + c) + d)
        x[:, 6:10] = rotations.normalize(x[:, 6:10])
        current[going] = x
        at, h = np.nonzero(reach[going] == done + 1)
        out[going[at], h] = x[at]
    return out


def _errors(rolled: Array, states: Array, ends: NDArray) -> Array:
    truth = states[ends]
    errors = np.full((*ends.shape, 4), np.nan)
    errors[..., 0] = np.linalg.norm(rolled[..., :3] - truth[..., :3], axis=-1)
    errors[..., 1] = np.linalg.norm(rolled[..., 3:6] - truth[..., 3:6], axis=-1)
    errors[..., 2] = rotations.angle_between(rolled[..., 6:10], truth[..., 6:10])
    errors[..., 3] = np.linalg.norm(rolled[..., 10:] - truth[..., 10:], axis=-1)
    errors[ends < 0] = np.nan
    return errors
