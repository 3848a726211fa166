"""What logs hold of the actuators: signed speeds, a commanded wrench alone, a sensor that reads nothing."""

from __future__ import annotations

import numpy as np

from infotraj.dynamics.allocation import Allocation
from infotraj.experiment.rough.columns import numbered, replaced
from infotraj.flight import COMMANDED_WRENCH, Flight
from infotraj.vehicle import Vehicle


def signed_speeds(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """Measured and commanded speeds with the sign of the direction of turning, as ROS drivers publish them."""
    spin = np.array([rotor.spin for rotor in vehicle.rotors])
    for prefix in ("rotor_", "cmd_rotor_"):
        names = numbered(flight, prefix)
        if names:
            flight = replaced(flight, names, flight.get(*names) * spin)
    return flight


def wrench(flight: Flight, vehicle: Vehicle, rng: np.random.Generator) -> Flight:
    """The commanded wrench instead of the commanded speeds, and no measured ones: what geometric controllers log."""
    names = [*numbered(flight, "cmd_rotor_"), *numbered(flight, "rotor_")]
    squared = flight.numbered("cmd_rotor_") ** 2 * [rotor.thrust_coefficient for rotor in vehicle.rotors]
    commanded = squared @ Allocation(vehicle).matrix[:, : len(vehicle.rotors)].T
    return replaced(Flight(flight.table.drop(columns=names), dict(flight.meta)), COMMANDED_WRENCH, commanded)


def dead_rotor_sensor(flight: Flight, rng: np.random.Generator) -> tuple[Flight, str]:
    """One measured (else commanded) rotor speed reads 0 in 60 to 90 % of the rows, from a row in flight on or in
    stretches; and the column's name."""
    names = numbered(flight, "rotor_") or numbered(flight, "cmd_rotor_")
    name = names[rng.integers(len(names))]
    values, share = flight.get(name).copy(), rng.uniform(0.6, 0.9)
    if rng.random() < 0.5:
        values[round((1.0 - share) * len(values)) :] = 0.0
    else:
        blocks = rng.random(len(values) // 200 + 1) < share
        values[np.repeat(blocks, 200)[: len(values)]] = 0.0
    return replaced(flight, (name,), values), name
