"""File profiles: by how much the numbers of a vehicle file are off, from exact to 10 %.

A profile is one share s, the error of a rotor's thrust coefficient. The other numbers are off in proportion to it, each
by what it costs to know it as well:

- mass, s / 2: any scale knows it, but batteries, cables and payload change between weighing and flight.
- thrust coefficient, s a rotor: a thrust stand reads to about a per cent, and rotors and motors of one kind differ by
  that and more (Foerster, System Identification of the Crazyflie 2.0, ETH Zurich 2015, measured each by itself).
- moment constant, 2 s a rotor: the torque is a hundredth of the thrust times a metre; a stand reads it worse.
- inertia, 2 s an axis: a careful bifilar pendulum reaches a per cent or so (Jardin and Mueller, Journal of Aircraft
  46(3), 2009), a sum of simple bodies 10 to 20 %.
- rotors' places 2 mm and centre of mass 1 mm at 3 %: a ruler's and a balance's errors, whatever the vehicle's size.
  Assumed. A rotor that tilts stays on its tilt's axis, where it is offset along the arm and along its thrust.
- lags of rotors and tilts, 5 s, all rotors alike: they depend on load, voltage and direction, and are rarely measured.
  Assumed.

All are standard deviations, of the logarithm where a number must be positive.
"""

from __future__ import annotations

import numpy as np

from infotraj.errors import UsageError, problem
from infotraj.vehicle import Inertia, Rotor, Vehicle

LEVELS: dict[str, float] = {"exact": 0.0, "1%": 0.01, "3%": 0.03, "10%": 0.10}
_MASS, _MOMENT, _INERTIA, _LAG = 0.5, 2.0, 2.0, 5.0  # times s
_PLACE, _CENTER = 0.002 / 0.03, 0.001 / 0.03  # m, times s


def wrong_file(vehicle: Vehicle, level: str, rng: np.random.Generator) -> Vehicle:
    """The file that a user would have written of `vehicle`; from equal `rng` the same errors, larger or smaller.

    UsageError for a level that is not in LEVELS.
    """
    if level not in LEVELS:
        raise UsageError(problem(f"file profile {level!r}", ", ".join(LEVELS), "Correct it."))
    s = LEVELS[level]
    if s == 0.0:
        return vehicle
    n = len(vehicle.rotors)
    thrust, moment = _factors(s, rng, n), _factors(_MOMENT * s, rng, n)
    places = _PLACE * s * rng.standard_normal((n, 3))
    mass, rotor_lag, tilt_lag = (_factors(share * s, rng, 1)[0] for share in (_MASS, _LAG, _LAG))
    center = np.array(vehicle.center_of_mass) + _CENTER * s * rng.standard_normal(3)
    rotors = tuple(
        rotor.model_copy(
            update={
                "position": _moved(vehicle, rotor, places[k]),
                "moment_constant": _written(rotor.moment_constant * moment[k]),
                "time_constant": _written(rotor.time_constant * rotor_lag),
                **_weaker(rotor.thrust_coefficient, rotor.thrust_polynomial, thrust[k]),
            }
        )
        for k, rotor in enumerate(vehicle.rotors)
    )
    tilts = tuple(t.model_copy(update={"time_constant": _written(t.time_constant * tilt_lag)}) for t in vehicle.tilts)
    changed = {
        "rotors": rotors,
        "tilts": tilts,
        "time_constant": _written(vehicle.time_constant * rotor_lag),
        "center_of_mass": tuple(center.round(5).tolist()),
    }
    if vehicle.mass is not None:
        changed["mass"] = _written(vehicle.mass * mass)
    if vehicle.inertia is not None:
        changed["inertia"] = _inertia(vehicle.inertia, s, rng)
    return vehicle.model_copy(update=changed)


def _moved(vehicle: Vehicle, rotor: Rotor, by: np.ndarray) -> tuple[float, ...]:
    if rotor.tilt is not None:
        along = np.array([vehicle.tilts[rotor.tilt].axis, rotor.axis])
        by = by[:2] @ along
    return tuple((np.array(rotor.position) + by).round(8).tolist())


def _factors(share: float, rng: np.random.Generator, count: int) -> np.ndarray:
    return np.exp(share * rng.standard_normal(count))


def _written(value: float) -> float:
    """To six digits, as a person writes it."""
    return float(f"{value:.6g}")


def _weaker(coefficient: float | None, polynomial: tuple[float, ...] | None, factor: float) -> dict[str, object]:
    out: dict[str, object] = {}
    if coefficient is not None:
        out["thrust_coefficient"] = _written(coefficient * factor)
    if polynomial is not None:
        out["thrust_polynomial"] = tuple(_written(c * factor) for c in polynomial)
    return out


def _inertia(true: Inertia, s: float, rng: np.random.Generator) -> Inertia:
    """Axis by axis, products of inertia unchanged; drawn again until some body can have it."""
    while True:
        xx, yy, zz = np.array([true.xx, true.yy, true.zz]) * _factors(_INERTIA * s, rng, 3)
        try:
            return Inertia(xx=_written(xx), yy=_written(yy), zz=_written(zz), xy=true.xy, xz=true.xz, yz=true.yz)
        except ValueError:
            continue
