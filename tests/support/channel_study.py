"""Measures `check` on faults of single channels. Not a test: it takes minutes.

usage: python tests/support/channel_study.py OUT.json [FLIGHTS_A_KIND]

Made-up flights with measured rotor speeds (see channel_faults.py), another one for each fault. Found: the finding names
all columns concerned, and nothing is cut. False: any finding of this family on a flight whose
channels are merely written in steps. Intervals are those of Clopper and Pearson (Biometrika 1934), 95 %.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from channel_faults import CODES, FAULTS, HEALTHY, measured

from infotraj.checking import outcome
from infotraj.checking.samples import sampled
from infotraj.evaluation.proportions import proportion


def found(fault, flight):
    findings = sampled(flight).findings
    hits = {c for f in findings if f.code == fault.code for c in f.channels}
    return set(fault.columns) <= hits and outcome(findings) in ("passed", "warning"), [f.code for f in findings]


def share(rows):
    found = proportion(sum(rows), len(rows))
    return {"count": found.count, "of": found.total, "ci95": [found.low, found.high]}


if __name__ == "__main__":
    out, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 15
    result: dict[str, dict] = {"found": {}, "false": {}}
    missed, every, seed = [], [], 1000
    for kind, fault in FAULTS.items():
        rows = []
        for _ in range(count):
            seed += 1
            rng = np.random.default_rng([3, seed])
            hit, codes = found(fault, fault.make(measured(seed, fault.rate_hz, commands=bool(seed % 3 == 0)), rng))
            rows.append(hit)
            if not hit:
                missed.append([kind, seed, codes])
        every += rows
        result["found"][kind] = share(rows)
        print(kind, result["found"][kind], file=sys.stderr, flush=True)
    result["found"]["all"] = share(every)
    every = []
    for kind, write in HEALTHY.items():
        rows = []
        for _ in range(count):
            seed += 1
            flight = write(measured(seed, (100.0, 200.0, 500.0)[seed % 3]), np.random.default_rng([3, seed]))
            codes = [f.code for f in sampled(flight).findings if f.code in CODES]
            rows.append(bool(codes))
            if codes:
                missed.append([kind, seed, codes])
        every += rows
        result["false"][kind] = share(rows)
        print("false:", kind, result["false"][kind], file=sys.stderr, flush=True)
    result["false"]["all"] = share(every)
    out.write_text(json.dumps({**result, "missed": missed}, indent=1))
    print(json.dumps(result["found"]["all"]), json.dumps(result["false"]["all"]))
