"""Faults of single channels put into made-up flights, for the tests and the study of `check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from check_flights import A, P, Q, V, W, simulated

from infotraj.flight import Flight

RPM = 2 * np.pi / 60


def measured(seed, rate_hz=100.0, duration=16.0, commands=False):
    """A made-up flight with measured rotor speeds (rad/s) in place of its commands, or beside them."""
    flight = simulated(seed, ("quadrotor", "omav")[seed % 2], rate_hz=rate_hz, duration=duration)
    rng = np.random.default_rng([91, seed])
    table = flight.table.copy()
    level = 1.0 + 0.08 * np.sin(np.outer(flight.t, rng.uniform(3, 9, 4)) + rng.uniform(0, 6, 4))
    for k in range(4):
        speed = table[f"cmd_rotor_{k}"] * level[:, k]
        table[f"cmd_rotor_{k}"] = speed
        table[f"rotor_{k}"] = speed + 3.0 * rng.standard_normal(len(table))
    if not commands:
        table = table.drop(columns=[f"cmd_rotor_{k}" for k in range(4)])
    return Flight(table, dict(flight.meta))


def held(flight, columns, every, jitter=0.0, phase=0.0, seed=0):
    """The columns as samples of every `every` rows, held until the next; `jitter`: its deviation, of the period."""
    rng = np.random.default_rng([17, seed])
    t, step = flight.t, float(np.median(np.diff(flight.t)))
    due = np.arange(phase * step, t[-1], every * step)
    due = np.sort(due + jitter * every * step * rng.standard_normal(len(due)))
    rows = np.clip(np.searchsorted(t, due - 1e-9), 0, len(t) - 1)
    last = np.zeros(len(t), dtype=int)
    last[rows] = rows
    last = np.maximum.accumulate(last)
    return changed(flight, **{c: flight.get(c)[last, 0] for c in columns})


def changed(flight, **columns):
    return Flight(flight.table.assign(**columns), dict(flight.meta))


def rounded(flight, columns, step):
    return changed(flight, **{c: step * np.round(flight.get(c)[:, 0] / step) for c in columns})


def stands(flight, column, start, stop, value=None):
    """The column at one value, the last one or `value`, from start to stop (s)."""
    t, x = flight.t, flight.get(column)[:, 0].copy()
    inside = (t >= start) & (t < stop)
    x[inside] = x[np.argmax(inside)] if value is None else value
    return changed(flight, **{column: x})


@dataclass(frozen=True)
class Fault:
    """`make(flight, rng)` spoils a flight made with `rate_hz`; `code` names it, `columns` are those concerned."""

    make: Callable
    code: str
    columns: tuple[str, ...]
    rate_hz: float = 100.0


def _span(flight: Flight, rng: np.random.Generator) -> tuple[float, float]:
    start = rng.uniform(4.5, 8.0)
    return start, start + rng.uniform(2.0, flight.t[-1] - start)


def _flicker(flight, rng):
    x = flight.get("rotor_1")[:, 0].copy()
    x[(flight.t > 4) & (rng.random(len(x)) < rng.uniform(0.1, 0.8))] = 0.0
    return changed(flight, rotor_1=x)


def _held(flight, rng):
    return held(
        flight, [*P, *Q, *V], rng.uniform(2, 10), rng.uniform(0, 0.2), rng.uniform(0, 3), int(rng.integers(1e6))
    )


def _coarse_held(flight, rng):
    coarse = rounded(flight, [f"rotor_{k}" for k in range(4)], 10 * RPM)
    return held(coarse, [f"rotor_{k}" for k in range(4)], rng.uniform(2, 10), 0.1, 0.0, int(rng.integers(1e6)))


def _wrapped(flight, column, share):
    x = flight.get(column)[:, 0]
    low, high = np.quantile(x[flight.t > 5], [0.02, share])
    return changed(flight, **{column: low + np.mod(x - low, high - low)})


def _clipped(flight, column, rng):
    x = flight.get(column)[:, 0]
    low, high = np.quantile(x[flight.t > 5], [rng.uniform(0.02, 0.1), rng.uniform(0.9, 0.98)])
    return changed(flight, **{column: np.clip(x, low, high)})


def _flipped(flight, rng):
    x = flight.get("rotor_2")[:, 0].copy()
    for start in rng.uniform(5, 12, 3):
        x[(flight.t >= start) & (flight.t < start + rng.uniform(0.3, 1.0))] *= -1
    return changed(flight, rotor_2=x)


FAULTS: dict[str, Fault] = {
    "a rotor reads zero": Fault(lambda f, r: stands(f, "rotor_1", *_span(f, r), 0.0), "dead_column", ("rotor_1",)),
    "a rotor reads its last value": Fault(lambda f, r: stands(f, "rotor_1", *_span(f, r)), "dead_column", ("rotor_1",)),
    "a rotor reads zero now and then": Fault(_flicker, "dead_column", ("rotor_1",)),
    "a rotor reads nothing at all": Fault(lambda f, r: changed(f, rotor_2=0.0), "dead_column", ("rotor_2",)),
    "a gyro axis reads its last value": Fault(lambda f, r: stands(f, "wy", *_span(f, r)), "dead_column", ("wy",)),
    "a gyro axis reads zero": Fault(lambda f, r: stands(f, "wz", *_span(f, r), 0.0), "dead_column", ("wz",)),
    "an accelerometer axis is zero throughout": Fault(lambda f, r: changed(f, ax=0.0), "dead_column", ("ax",)),
    "pose and velocity held": Fault(_held, "held", (*P, *Q, *V), 500.0),
    "gyro and accelerometer held": Fault(
        lambda f, r: held(f, [*W, *A], r.uniform(2, 10), 0.1, 0.0, int(r.integers(1e6))), "held", (*W, *A), 500.0
    ),
    "coarse rotor speeds held": Fault(_coarse_held, "held", tuple(f"rotor_{k}" for k in range(4)), 500.0),
    "rates in steps as large as they are": Fault(
        lambda f, r: rounded(f, ["wx"], r.uniform(1.3, 2.0) * f.get("wx")[f.t > 5].std()), "quantised", ("wx",)
    ),
    "a position's counter wraps": Fault(lambda f, r: _wrapped(f, "px", r.uniform(0.6, 0.8)), "wrapped", ("px",)),
    "a rotor changes its sign": Fault(_flipped, "sign_flips", ("rotor_2",)),
    "a clipped gyro": Fault(lambda f, r: _clipped(f, "wx", r), "saturated", ("wx",)),
    "a clipped accelerometer": Fault(lambda f, r: _clipped(f, "az", r), "saturated", ("az",)),
}

HEALTHY: dict[str, Callable] = {
    "as it is": lambda f, r: f,
    "rotor speeds in steps of 10 rpm": lambda f, r: rounded(f, [f"rotor_{k}" for k in range(4)], 10 * RPM),
    "positions in mm": lambda f, r: rounded(f, P, 1e-3),
    "positions and velocities in cm": lambda f, r: rounded(f, [*P, *V], 1e-2),
    "gyro in steps of 1 deg/s": lambda f, r: rounded(f, W, np.radians(1.0)),
    "16 bit sensors": lambda f, r: rounded(rounded(f, W, np.radians(0.061)), A, 9.81 / 2048),
}
CODES = ("held", "stuck", "dead_stream", "dead_column", "wrapped", "sign_flips", "quantised", "saturated")
