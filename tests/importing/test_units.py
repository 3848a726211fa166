"""Every unit against what it is by definition, written down apart from the table."""

import numpy as np
import pytest

from infotraj.importing.units import UNITS, conversion

# So many of this unit are so much in SI. Exact by definition: the international inch and foot, standard gravity.
KNOWN = {
    "time": {"s": (1, 1), "ms": (1000, 1), "us": (1e6, 1), "ns": (1e9, 1)},
    "length": {
        "m": (1, 1), "cm": (100, 1), "mm": (1000, 1), "km": (1, 1000), "um": (1e6, 1),
        "in": (1000, 25.4), "ft": (1, 0.3048),
    },
    "angle": {"rad": (1, 1), "mrad": (1000, 1), "deg": (180, np.pi), "cdeg": (18000, np.pi), "rev": (1, 2 * np.pi)},
    "speed": {"m/s": (1, 1), "cm/s": (100, 1), "mm/s": (1000, 1), "km/h": (36, 10), "ft/s": (1, 0.3048)},
    "rate": {
        "rad/s": (1, 1), "mrad/s": (1000, 1), "deg/s": (180, np.pi), "mdeg/s": (180_000, np.pi),
        "cdeg/s": (18000, np.pi),
    },
    "acceleration": {
        "m/s^2": (1, 1), "cm/s^2": (100, 1), "mm/s^2": (1000, 1), "g": (1, 9.80665), "mg": (1000, 9.80665),
    },
    "force": {"N": (1, 1), "mN": (1000, 1), "kgf": (1, 9.80665), "gf": (1000, 9.80665)},
    "torque": {"N m": (1, 1), "N cm": (100, 1), "N mm": (1000, 1), "mN m": (1000, 1), "kgf cm": (100, 9.80665)},
    "rotor": {
        "rad/s": (1, 1), "rpm": (60, 2 * np.pi), "krpm": (0.06, 2 * np.pi), "rev/s": (1, 2 * np.pi), "throttle": (1, 1),
        "percent": (100, 1), "pwm16": (65535, 1), "pwm_us": (2000, 1), "dshot": (2047, 1), "duty8": (255, 1),
        "N": (1, 1), "mN": (1000, 1), "gf": (1000, 9.80665),
    },
    "voltage": {"V": (1, 1), "mV": (1000, 1), "cV": (100, 1)},
    "number": {"1": (1, 1)},
}  # fmt: skip
# What these make 0: their lowest command.
ZERO = {("rotor", "pwm_us"): 1000, ("rotor", "dshot"): 47}


@pytest.mark.parametrize(("dimension", "unit"), [(d, u) for d, units in UNITS.items() for u in units if u != "counts"])
def test_a_unit_is_what_it_is_by_definition(dimension, unit):
    factor, offset = conversion(dimension, unit)
    count, si = KNOWN[dimension][unit]
    assert factor * count + offset == pytest.approx(si, rel=1e-12)
    assert factor * ZERO.get((dimension, unit), 0) + offset == pytest.approx(0.0, abs=1e-15)
