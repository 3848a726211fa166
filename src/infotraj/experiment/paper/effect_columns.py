"""What the catalogue's effects would add to the torque along a simulated flight: columns of a prior that knows them."""

from __future__ import annotations

from functools import cache

import numpy as np

from infotraj.diagnosis.linear.candidates import candidates, places, variants
from infotraj.effects.registry import catalogue
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.rotations import Array
from infotraj.vehicle import Vehicle

_PLACES = (
    "thrust",
    "wrench",
    "rigid body",
)  # lags and sensors are no functions of the state, to be inverted


@cache
def _known():
    return {n: cls for n, cls in catalogue().items() if cls.place in _PLACES or n == "servo_bias"}


def effect_columns(vehicle: Vehicle, flight: Flight) -> tuple[list[str], Array]:
    """Names (k,) and columns (n, 3, k): change of the angular acceleration (rad/s^2) by a usual size of each number."""
    found, _ = candidates(_known(), vehicle, [flight])
    nominal = Model(vehicle)
    prepared = nominal.prepare(flight)
    before = nominal.predict(prepared).angular_acceleration
    names, columns = [], []
    for candidate in found:
        scales = [place.scale for place in places(candidate, vehicle)]
        for index, effect, step in variants(candidate, vehicle)[0].points:
            try:
                with np.errstate(all="ignore"):
                    after = Model(vehicle, [effect]).predict(prepared).angular_acceleration
            except InputError:
                continue
            names.append(f"{candidate.label} {index}")
            columns.append(np.nan_to_num((after - before) * scales[index] / step))
    return names, np.stack(columns, axis=2)
