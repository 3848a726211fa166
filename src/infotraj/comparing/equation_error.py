"""Equation error: body force and torque predicted from recorded state and commands, against those that were measured.

Torque: the measured rate minus the integral of the predicted angular acceleration, through the least-squares slope of a
window; that is the measured slope minus the slope of the prediction, by the same operator at the same samples. Force:
measured minus predicted specific force through the mean of that window, where there is an accelerometer; otherwise, or
where it is asked for, velocity minus the integral of the predicted acceleration through the slope. Rotor commands jump
from row to row, so the integral of the prediction is what a rate can be compared with, not its value at the rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from infotraj import rotations
from infotraj.checking.airborne import airborne_rows
from infotraj.comparing.floor import RED, colour, fast_part, white_noise
from infotraj.comparing.window import Window
from infotraj.effects.channels import from_velocity, is_derived
from infotraj.flight import ATTITUDE, RATE, SPECIFIC_FORCE, VELOCITY, Flight
from infotraj.models import Model, Prediction
from infotraj.models.interpolation import interpolate
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
WINDOW = 0.15  # s
SETTLING = 0.5  # s after the first row that are not scored: the actuators start at their first command
ForceFrom = Literal["auto", "accelerometer", "velocity"]


@dataclass(frozen=True)
class EquationError:
    """Measured and predicted wrench at the n rows of a flight, through one filter; NaN where a row is not scored.

    t (n,) s; measured, predicted (n, 6) in `unit`; floor (6,): standard deviation that noise of the sensors leaves
    in measured minus predicted (see comparing.floor); red (6,): noise seen over half a window over that of
    neighbours, 1 if white;
    scored (n, 6) bool; reasons: axis to why it cannot be answered; unit: of force and of torque; force_from: what the
    force was measured with; window (s); left_out: rows that are not scored, counted by reason.
    """

    t: Array
    measured: Array
    predicted: Array
    floor: Array
    red: Array
    unit: dict[str, str]
    force_from: str
    window: float
    reasons: dict[str, str]
    left_out: dict[str, int]

    @property
    def residual(self) -> Array:
        """Measured minus predicted (n, 6)."""
        return self.measured - self.predicted

    @property
    def scored(self) -> NDArray[np.bool_]:
        """Where there is a residual (n, 6)."""
        return np.isfinite(self.measured) & np.isfinite(self.predicted)

    @property
    def filter(self) -> str:
        """The filter in one sentence, for people and for JSON."""
        force = (
            f"mean of the specific force with parabolic weights over {self.window:g} s"
            if self.force_from == "accelerometer"
            else f"least-squares slope of the velocity over {self.window:g} s"
        )
        return f"force: {force}; torque: least-squares slope of the rate over {self.window:g} s; same on both sides"


def equation_error(
    model: Model,
    flight: Flight,
    *,
    window: float = WINDOW,
    force_from: ForceFrom = "auto",
    start: float | None = None,
    stop: float | None = None,
    scale: Vehicle | None = None,
) -> EquationError:
    """Measured against predicted wrench along a flight.

    window: s, of the filter. force_from: "auto" takes the accelerometer where it was measured, else the velocity.
    start, stop: s, the part of the flight that is scored; the prediction always starts with the flight. scale: the
    vehicle whose mass and inertia accelerations are multiplied by, the model's own without. InputError where the flight
    lacks the commands that the vehicle needs.
    """
    prepared = model.prepare(flight)
    flight, prediction = prepared.flight, model.predict(prepared)
    t, vehicle = flight.t, model.vehicle
    keep, left_out = _scored_rows(flight, vehicle, prediction, start, stop)
    reasons = {axis: why for axis, why in prediction.testable.items() if why is not None}
    measured, predicted = np.full((len(t), 6), np.nan), np.full((len(t), 6), np.nan)
    floor, red = np.full(6, np.nan), np.full(6, np.nan)

    source = _force_source(flight, force_from)
    if source == "none":
        reasons.update(dict.fromkeys(AXES[:3], "the flight has neither specific force nor velocity with attitude"))
    elif np.isfinite(prediction.specific_force).any():
        # The prediction is there, and so is a side to measure it by, whatever the accelerometer lacks.
        reasons = {axis: why for axis, why in reasons.items() if axis not in AXES[:3]}
    force = _force(flight, vehicle, prediction, keep, window, source)
    torque = _torque(flight, prediction, keep, window)
    if not flight.has(*RATE):
        reasons.update(dict.fromkeys(AXES[3:], "the flight has no rates"))
    scale = vehicle if scale is None else scale
    weights = _weights(scale)
    for columns, side, weight in ((slice(0, 3), force, weights[0]), (slice(3, 6), torque, weights[1])):
        if side is None:
            continue
        measured[:, columns], predicted[:, columns] = side.measured @ weight, side.predicted @ weight
        floor[columns] = np.sqrt(np.square(side.floor) @ np.square(weight))
        red[columns] = side.red
    coloured = red > RED
    if coloured.any():
        for columns in (slice(0, 3), slice(3, 6)):
            floor[columns] = np.where(
                coloured[columns], fast_part(t, measured[:, columns] - predicted[:, columns], window), floor[columns]
            )
    for k, axis in enumerate(AXES):
        if axis in reasons:
            measured[:, k], predicted[:, k], floor[k], red[k] = np.nan, np.nan, np.nan, np.nan
    unit = {
        "force": "N" if scale.mass is not None else "m/s^2",
        "torque": "N m" if scale.inertia is not None else "rad/s^2",
    }
    return EquationError(t, measured, predicted, floor, red, unit, source, window, reasons, left_out)


@dataclass(frozen=True)
class _Side:
    """One of force and torque as acceleration: measured, predicted (n, 3); floor (3,), red (3,)."""

    measured: Array
    predicted: Array
    floor: Array
    red: Array


def _torque(flight: Flight, prediction: Prediction, keep: NDArray, seconds: float) -> _Side | None:
    if not flight.has(*RATE):
        return None
    rate = flight.get(*RATE)
    return _by_slope(flight.t, rate, prediction.angular_acceleration_mean, keep, seconds)


def _force(
    flight: Flight, vehicle: Vehicle, prediction: Prediction, keep: NDArray, seconds: float, source: str
) -> _Side | None:
    t = flight.t
    if source == "accelerometer":
        measured, predicted = flight.get(*SPECIFIC_FORCE), prediction.specific_force
        rows = np.flatnonzero(keep & np.isfinite(measured).all(axis=1) & np.isfinite(predicted).all(axis=1))
        if len(rows) < 3:
            return None
        window = Window.over(t[rows], seconds)
        error = measured[rows] - predicted[rows]
        gain = _rms(window.mean_gain())
        seen, wanted = (_spread(window.mean(x[rows]), rows, len(t)) for x in (measured, predicted))
        return _Side(seen, wanted, white_noise(t[rows], error) * gain, colour(t[rows], error, max(1, window.half // 3)))
    if source == "none":
        return None
    known = np.isfinite(flight.get(*ATTITUDE)).all(axis=1)
    q = rotations.continuous(rotations.normalize(flight.get(*ATTITUDE)[known]))
    half_way = np.append(0.5 * (t[1:] + t[:-1]), t[-1])
    turned = rotations.normalize(interpolate(t[known], q, half_way))
    mean = rotations.to_world(turned, prediction.specific_force_mean) - [0.0, 0.0, vehicle.gravity]
    side = _by_slope(t, flight.get(*VELOCITY), mean, keep, seconds)
    if side is None:
        return None
    here = rotations.normalize(interpolate(t[known], q, t))
    gravity = np.array([0.0, 0.0, vehicle.gravity])
    measured, predicted = (rotations.to_body(here, x + gravity) for x in (side.measured, side.predicted))
    used = np.isfinite(side.measured).all(axis=1)
    floor = np.sqrt(np.mean(np.square(rotations.matrix(here[used])), axis=0).T @ np.square(side.floor))
    return _Side(measured, predicted, floor, side.red)


def _by_slope(t: Array, x: Array, mean: Array, keep: NDArray, seconds: float) -> _Side | None:
    """Slope of x (n, 3) and of the integral of `mean` (n, 3), row k from t[k] to t[k+1], at the same samples."""
    whole = np.all(np.isfinite(mean), axis=1)
    whole[-1] = True  # there is no step after the last row
    # A step without a prediction parts the integral: rows are dropped until no window reaches over it.
    whole = np.lib.stride_tricks.sliding_window_view(np.pad(whole, (4, 0), constant_values=True), 5).all(axis=1)
    rows = np.flatnonzero(keep & whole & np.isfinite(x).all(axis=1))
    if len(rows) < 3:
        return None
    step = np.diff(t)[:, None] * np.nan_to_num(mean[:-1])
    integral = np.concatenate([np.zeros((1, 3)), np.cumsum(step, axis=0)])
    window = Window.over(t[rows], seconds)
    seen, wanted = (_spread(window.slope(values[rows]), rows, len(t)) for values in (x, integral))
    error = x[rows] - integral[rows]
    noise = white_noise(t[rows], error)
    return _Side(seen, wanted, noise * _rms(window.slope_gain()), colour(t[rows], error, max(1, window.half // 3)))


def _scored_rows(
    flight: Flight, vehicle: Vehicle, prediction: Prediction, start: float | None, stop: float | None
) -> tuple[NDArray, dict[str, int]]:
    t = flight.t
    outside = (t < (start if start is not None else -np.inf)) | (t >= (stop if stop is not None else np.inf))
    reasons = {
        "outside --from and --to": outside,
        "first half second": t < t[0] + SETTLING,
        "not in the air": ~airborne_rows(flight, vehicle).rows,
        "inputs do not reach": ~np.asarray(prediction.covered, dtype=bool),
    }
    keep = np.ones(len(t), dtype=bool)
    left_out = {}
    for reason, rows in reasons.items():
        left_out[reason] = int((keep & rows).sum())
        keep &= ~rows
    return keep, left_out


def _force_source(flight: Flight, asked: ForceFrom) -> str:
    has_velocity = flight.has(*VELOCITY) and flight.has(*ATTITUDE)
    has_accelerometer = flight.has(*SPECIFIC_FORCE) and not (asked == "auto" and from_velocity(flight))
    if asked == "velocity":
        return "velocity" if has_velocity else "none"
    if has_accelerometer and (asked == "accelerometer" or not is_derived(flight, SPECIFIC_FORCE)):
        return "accelerometer"
    if has_velocity and asked == "auto":
        return "velocity"
    return "none"


def _weights(vehicle: Vehicle) -> tuple[Array, Array]:
    """What accelerations (n, 3) are multiplied by from the right: mass and inertia, 1 where they are not known."""
    mass = 1.0 if vehicle.mass is None else vehicle.mass
    return mass * np.eye(3), np.eye(3) if vehicle.inertia is None else vehicle.inertia.matrix()


def _spread(values: Array, rows: NDArray, count: int) -> Array:
    out = np.full((count, values.shape[1]), np.nan)
    out[rows] = values
    return out


def _rms(x: Array) -> float:
    good = np.isfinite(x)
    return float(np.sqrt(np.mean(np.square(x[good])))) if good.any() else float("nan")
