"""The held-out error by which the scorer of the hidden-effect study compares models."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infotraj.diagnosis.measure.residual import FlightSamples, flight_samples
from infotraj.errors import InfotrajError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

# s, of levels, and of steps between rows, whose noise does not grow with the time between them
WINDOW = {False: 0.05, True: 0.25}


class HeldOut:
    """Held-out flights, and the same without anything hidden, which give the noise floor.

    The error of a model: its residuals (specific force, change of rate, recorded attitude and velocity against the
    IMU) as means over 50 ms or 0.25 s, squared and divided by the same mean square without hidden effects, averaged
    over the axes. 1 is the floor. White noise of single samples would hide what a model of the motion is for.
    vehicle: the file as it should be; models may be of a file that is wrong.
    """

    def __init__(self, vehicle: Vehicle, flights: Sequence[Flight], floor: Sequence[Flight]) -> None:
        base = Model(vehicle)
        self._flights = tuple(flights)
        self._samples: dict[str, list[FlightSamples]] = {}
        self._floor = _mean_squares([flight_samples(base, f) for f in floor], base)

    def error(self, model: Model, quantity: str = "") -> float:
        """Mean over the axes of all quantities, or of one, in units of the floor; infinite where the model cannot be
        evaluated."""
        try:
            found = _mean_squares(self._of(model.vehicle), model)
        except InfotrajError:
            return float("inf")
        shared = [name for name in found if name in self._floor and quantity in ("", name)]
        if not shared:
            return float("nan")
        return float(np.mean([found[name] / self._floor[name] for name in shared]))

    def _of(self, vehicle: Vehicle) -> list[FlightSamples]:
        """The flights as this file reads them."""
        key = vehicle.model_dump_json()
        if key not in self._samples:
            self._samples[key] = [flight_samples(Model(vehicle), flight) for flight in self._flights]
        return self._samples[key]


def _mean_squares(samples: Sequence, model: Model) -> dict[str, Array]:
    """Mean square (3,) of the windowed residual of each channel over all flights."""
    parts: dict[str, list[Array]] = {}
    for s in samples:
        for channel, values in zip(s.channels, s.residual(model), strict=True):
            rows = max(1, round(WINDOW[channel.difference] / channel.step))
            whole = values[: len(values) // rows * rows].reshape(-1, rows, 3).mean(axis=1)
            parts.setdefault(channel.name, []).append(whole)
    return {name: np.mean(np.concatenate(p) ** 2, axis=0) for name, p in parts.items()}
