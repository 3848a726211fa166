"""The thrust map of NanoBench's Crazyflie, fitted to five named flights: where the numbers of its files come from.

    python -m infotraj.experiment.real.thrust_map

Thrust of one rotor: (c1 x + c2 x^2) (V / V_nominal)^e, x the throttle (PWM / 65535) after a first-order lag, V the
battery voltage. Fitted to the vertical specific force that the motion capture gives (least-squares slope of the
velocity over 0.15 s; the thrust passes the same mean), by least squares over c1 and c2 for each lag and exponent of a
grid. Only the ratio of thrust to mass shows in a flight: with another mass all of c1 and c2 scale with it, and no
error changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from infotraj import rotations
from infotraj.checking.airborne import airborne_rows
from infotraj.comparing.equation_error import SETTLING, WINDOW
from infotraj.comparing.window import Window
from infotraj.datasets import location
from infotraj.dynamics.response import respond
from infotraj.flight import ATTITUDE, VELOCITY, Flight
from infotraj.rotations import Array

# Chosen before the fit: two slow or medium figures, one fast flight, and two long medium ones, over 3.2 to 3.6 V.
FLIGHTS = (
    "B3_figure8_slow_rep1",
    "B3_figure8_medium_rep1",
    "B5_helix_medium_rep1",
    "B9_trefoil_medium_rep1",
    "B10_lissajous_fast_rep1",
)
MASS, GRAVITY, NOMINAL_VOLTAGE = 0.027, 9.81, 4.2
LAGS = np.arange(0.0, 0.1001, 0.005)
EXPONENTS = np.arange(0.0, 3.001, 0.1)
LOWEST = 0.3  # m: five rotor diameters, clear of the ground
_BATTERY_WINDOW = 51  # rows, 0.5 s: the logged voltage spikes


@dataclass(frozen=True)
class ThrustMap:
    """(c1 x + c2 x^2) (V / NOMINAL_VOLTAGE)^exponent in N, x after a lag of time_constant (s); rmse in m/s^2 and the
    share of the variance of the vertical specific force that it explains."""

    c1: float
    c2: float
    exponent: float
    time_constant: float
    rmse: float
    explained: float


def fit_thrust_map(
    flights: Sequence[Flight],
    *,
    exponents: Iterable[float] = EXPONENTS,
    time_constants: Iterable[float] = LAGS,
    linear_only: bool = False,
) -> ThrustMap:
    """The best map over the grid of lags and exponents; `exponents=[0]` leaves the voltage out, linear_only c2."""
    best: ThrustMap | None = None
    prepared = [_prepared(f) for f in flights]
    for lag in time_constants:
        lagged = [(respond(t, x, lag, np.inf), volts, window, keep, up) for t, x, volts, window, keep, up in prepared]
        for exponent in exponents:
            design, target = [], []
            for x, volts, window, keep, up in lagged:
                factor = (volts / NOMINAL_VOLTAGE) ** exponent
                square = np.zeros(len(x)) if linear_only else np.square(x).sum(axis=1)
                columns = np.column_stack([x.sum(axis=1) * factor, square * factor])
                design.append(window.mean(columns)[keep])
                target.append(MASS * up[keep])
            a, b = np.concatenate(design), np.concatenate(target)
            solved = np.linalg.lstsq(a, b, rcond=None)[0]
            left = b - a @ solved
            rmse = float(np.sqrt(np.mean(left**2))) / MASS
            if best is None or rmse < best.rmse:
                explained = 1.0 - float(np.mean(left**2) / np.var(b))
                linear, quadratic = map(float, solved)
                best = ThrustMap(linear, quadratic, float(exponent), float(lag), rmse, explained)
    assert best is not None
    return best


def _prepared(flight: Flight) -> tuple[Array, Array, Array, Window, Array, Array]:
    t = flight.t
    window = Window.over(t, WINDOW)
    acceleration = window.slope(flight.get(*VELOCITY)) + np.array([0.0, 0.0, GRAVITY])
    up = rotations.to_body(flight.get(*ATTITUDE), acceleration)[:, 2]
    keep = airborne_rows(flight).rows & (flight.get("pz")[:, 0] > LOWEST) & (t > t[0] + SETTLING) & np.isfinite(up)
    volts = median_filter(flight.get("battery")[:, 0], _BATTERY_WINDOW)
    return t, flight.numbered("cmd_rotor_"), volts, window, keep, up


def named_flights() -> list[Flight]:
    """The five flights. InputError where the data set is not on this machine."""
    from infotraj.importing import import_log

    folder = location.dataset("nanobench")
    return [import_log(folder / f"{name}.parquet", "nanobench") for name in FLIGHTS]


if __name__ == "__main__":
    _flights = named_flights()
    _best = fit_thrust_map(_flights)
    print(f"with voltage: {_best}")
    _alone: dict[str, Any] = {"exponents": [0.0], "time_constants": [_best.time_constant]}
    print(f"proportional to PWM, same lag: {fit_thrust_map(_flights, linear_only=True, **_alone)}")
    print(f"PWM alone, two coefficients: {fit_thrust_map(_flights, **_alone)}")
