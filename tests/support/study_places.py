"""How often `locate` names a place where there is none, and how often the right quantity first where there is one.

usage: python tests/support/study_places.py [FLIGHTS A CASE] [SECONDS] [FIRST SEED]

Flights of tests/support/fast_flyer.py: random smooth references, sensor noise of the specification, one hidden effect
of usual size or none. Prints a Markdown table. Takes about 0.7 s a flight.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import fast_flyer
import numpy as np

from infotraj.flight import Flight
from infotraj.locating.locating import locate
from infotraj.models import load_model

VEHICLES = Path(__file__).parents[2] / "config" / "vehicles"
# effect, its size in the middle of the catalogue's usual range, the groups that name it, least height of the flight (m)
CASES = {
    "omav": [
        ("none", 0.0, set(), 1.0),
        ("linear_drag", 0.3, {"speed"}, 1.0),
        ("ground_effect", 0.2, {"height"}, 0.35),
        ("battery_sag", 0.003, {"time", "battery"}, 1.0),
        ("rotor_interference", 0.06, {"tilt"}, 1.0),
        ("servo_lag", 0.03, {"tilt rate"}, 1.0),
    ],
    "quadrotor": [
        ("none", 0.0, set(), 1.0),
        ("linear_drag", 0.1, {"speed"}, 1.0),
        ("ground_effect", 0.2, {"height"}, 0.15),
        ("battery_sag", 0.003, {"time", "battery"}, 1.0),
    ],
}


def main(flights: int = 20, seconds: float = 20.0, first_seed: int = 1000) -> None:
    print("| vehicle | hidden effect | flights | right quantity first | with a place | first groups named |")
    print("|---|---|---|---|---|---|")
    for vehicle, cases in CASES.items():
        path = VEHICLES / f"{vehicle}.yaml"
        model = load_model(path)
        for name, size, right, low in cases:
            first: Counter = Counter()
            count = flights * (3 if name == "none" else 1)
            for seed in range(count):
                hidden = {} if name == "none" else {name: size}
                table = fast_flyer.fly(path, seconds, first_seed + seed, hidden, low=low)
                located = locate(model, [Flight(table)], rng=np.random.default_rng(seed))
                first[located.places[0].group if located.places else "no place"] += 1
            hits = sum(first[g] for g in right) if right else first["no place"]
            said = ", ".join(f"{g} {n}" for g, n in first.most_common())
            places = count - first["no place"]
            print(f"| {vehicle} | {name} {size or ''} | {count} | {hits} | {places} | {said} |", flush=True)


if __name__ == "__main__":
    main(*(kind(a) for kind, a in zip((int, float, int), sys.argv[1:], strict=False)))
