"""Measures `check`: injected errors found, and false findings on untouched good segments. Not a test: it takes minutes.

usage: INFOTRAJ_DATA=FOLDER python tests/check_study.py OUT.json

Flights: NanoBench's good ones, made-up ones (quadrotors and vehicles that turn as they like; 50 to 500 Hz; noise from a
third to twice the usual), and flights of the MuJoCo omav. An error counts as found where a finding of severity warning
or worse names it rightly. Intervals are those of Clopper and Pearson (Biometrika 1934), 95 %.
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from check_flights import SPOILED, V, named, plant_flights, simulated
from scipy import stats

from infotraj.checking import examine
from infotraj.datasets import nanobench
from infotraj.datasets.location import find_dataset

SEGMENT = 10.0


def interval(hits, n):
    low = stats.beta.ppf(0.025, hits, n - hits + 1) if hits else 0.0
    high = stats.beta.ppf(0.975, hits + 1, n - hits) if hits < n else 1.0
    return [float(low), float(high)]


def made_up(seeds):
    for k in seeds:
        kind = "quadrotor" if k % 2 else "omav"
        rate = (50.0, 100.0, 200.0, 500.0)[k % 4]
        yield simulated(k, kind, rate_hz=rate, duration=24.0, noise=(0.33, 1.0, 2.0)[k % 3])


def real():
    folder = find_dataset("nanobench")
    if folder is None:
        sys.exit("INFOTRAJ_DATA names no folder with nanobench")
    for path in nanobench.good_flights(folder).values():
        yield nanobench.read(path)


def segments(flights):
    for flight in flights:
        flown = flight.t
        if flight.has("pz"):
            high = flight.get("pz")[:, 0] > np.nanmin(flight.get("pz")) + 0.3
            flown = flight.t[high] if high.mean() > 0.3 else flight.t
        for start in np.arange(flown[0] + 1, flown[-1] - SEGMENT - 1, SEGMENT):
            yield flight.between(start, start + SEGMENT)


def injected(groups):
    rows = []
    for group, flights in groups.items():
        for flight in flights:
            print("injecting into", flight.meta["source"], file=sys.stderr, flush=True)
            for kind, (spoil, codes) in SPOILED.items():
                if kind.startswith("velocity") and not flight.has(*V):
                    continue
                got = named(examine(spoil(flight)))
                rows.append([group, flight.meta["source"].split("/")[-1], kind, bool(got & set(codes)), sorted(got)])
    return rows


def untouched(groups):
    rows = []
    for group, flights in groups.items():
        for piece in segments(flights):
            got = named(examine(piece))
            rows.append([group, piece.meta["source"].split("/")[-1], float(piece.t[0]), sorted(got)])
    return rows


def summary(found, false):
    out = {"injected": {}, "kinds": {}, "misses": [r for r in found if not r[3]], "false": [r for r in false if r[3]]}
    by = defaultdict(list)
    for group, _, kind, hit, _ in found:
        by["all"].append(hit)
        by[group].append(hit)
        by[kind].append(hit)
    for name, hits in by.items():
        where = out["kinds"] if name in SPOILED else out["injected"]
        where[name] = {
            "found": sum(hits),
            "of": len(hits),
            "share": float(np.mean(hits)),
            "ci95": interval(sum(hits), len(hits)),
        }
    wrong = defaultdict(list)
    for group, _, _, got in false:
        wrong["all"].append(bool(got))
        wrong[group].append(bool(got))
    out["untouched"] = {
        g: {"false": sum(w), "of": len(w), "share": float(np.mean(w)), "ci95": interval(sum(w), len(w))}
        for g, w in wrong.items()
    }
    return out


if __name__ == "__main__":
    out = Path(sys.argv[1])
    few = "--few" in sys.argv
    groups = {
        "nanobench": (lambda: list(real())[:: 7 if few else 1],) * 2,
        "made up": (lambda: made_up(range(2 if few else 10)), lambda: made_up(range(100, 102 if few else 130))),
        "mujoco omav": (lambda: plant_flights(1 if few else 2), lambda: plant_flights(1 if few else 3)),
    }
    asked = sys.argv[sys.argv.index("--only") + 1 :] if "--only" in sys.argv else list(groups)
    before = json.loads(out.read_text()) if out.is_file() and "--only" in sys.argv else {"rows": [[], []]}
    found, false = ([r for r in rows if r[0] not in asked] for rows in before["rows"])
    for name in asked:
        spoilt, good = groups[name]
        found += injected({name: spoilt()})
        false += untouched({name: good()})
    result = {**summary(found, false), "rows": [found, false]}
    out.write_text(json.dumps(result, indent=1))
    print(json.dumps({k: result[k] for k in ("injected", "untouched", "kinds", "false")}, indent=1))
    for miss in result["misses"]:
        print("missed", miss)
