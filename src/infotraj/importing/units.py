"""Units by name: what a log's numbers have to be multiplied with (and shifted by) to be SI.

Every unit is (factor, offset): value in SI = factor x value in the log + offset.
"""

from __future__ import annotations

import numpy as np

STANDARD_GRAVITY = 9.80665  # m/s^2, CGPM 1901: what a data sheet means by 1 g

_DEG = float(np.pi / 180.0)
_RPM = float(2.0 * np.pi / 60.0)

UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "time": {"s": (1.0, 0.0), "ms": (1e-3, 0.0), "us": (1e-6, 0.0), "ns": (1e-9, 0.0)},
    "length": {
        "m": (1.0, 0.0),
        "cm": (1e-2, 0.0),
        "mm": (1e-3, 0.0),
        "km": (1e3, 0.0),
        "um": (1e-6, 0.0),
        "in": (0.0254, 0.0),
        "ft": (0.3048, 0.0),
    },
    "angle": {
        "rad": (1.0, 0.0),
        "mrad": (1e-3, 0.0),
        "deg": (_DEG, 0.0),
        "cdeg": (_DEG / 100.0, 0.0),
        "rev": (2.0 * float(np.pi), 0.0),
    },
    "speed": {
        "m/s": (1.0, 0.0),
        "cm/s": (1e-2, 0.0),
        "mm/s": (1e-3, 0.0),
        "km/h": (1.0 / 3.6, 0.0),
        "ft/s": (0.3048, 0.0),
    },
    "rate": {
        "rad/s": (1.0, 0.0),
        "mrad/s": (1e-3, 0.0),
        "deg/s": (_DEG, 0.0),
        "mdeg/s": (_DEG / 1000.0, 0.0),
        "cdeg/s": (_DEG / 100.0, 0.0),
    },
    "acceleration": {
        "m/s^2": (1.0, 0.0),
        "cm/s^2": (1e-2, 0.0),
        "mm/s^2": (1e-3, 0.0),
        "g": (STANDARD_GRAVITY, 0.0),
        "mg": (STANDARD_GRAVITY / 1000.0, 0.0),
    },
    "force": {"N": (1.0, 0.0), "mN": (1e-3, 0.0), "kgf": (STANDARD_GRAVITY, 0.0), "gf": (STANDARD_GRAVITY / 1e3, 0.0)},
    "torque": {
        "N m": (1.0, 0.0),
        "N cm": (1e-2, 0.0),
        "N mm": (1e-3, 0.0),
        "mN m": (1e-3, 0.0),
        "kgf cm": (STANDARD_GRAVITY / 100.0, 0.0),
    },
    # A rotor's speed in rad/s, its throttle 0..1, or its thrust in N; which of them is the vehicle file's `input`.
    "rotor": {
        "rad/s": (1.0, 0.0),
        "rpm": (_RPM, 0.0),
        "krpm": (1000.0 * _RPM, 0.0),
        "rev/s": (60.0 * _RPM, 0.0),
        "throttle": (1.0, 0.0),
        "percent": (1e-2, 0.0),
        "pwm16": (1.0 / 65535.0, 0.0),  # 0..65535, as the Crazyflie logs it
        "pwm_us": (1e-3, -1.0),  # pulse of 1000..2000 us
        "dshot": (1.0 / 2000.0, -47.0 / 2000.0),  # 47..2047
        "duty8": (1.0 / 255.0, 0.0),  # 0..255
        "N": (1.0, 0.0),
        "mN": (1e-3, 0.0),
        "gf": (STANDARD_GRAVITY / 1e3, 0.0),
    },
    "voltage": {"V": (1.0, 0.0), "mV": (1e-3, 0.0), "cV": (1e-2, 0.0)},
    "number": {"1": (1.0, 0.0)},
}

# What a rotor's unit makes the number: the vehicle file's `input`.
ROTOR_INPUT = {
    **dict.fromkeys(("rad/s", "rpm", "krpm", "rev/s"), "speed"),
    **dict.fromkeys(("throttle", "percent", "pwm16", "pwm_us", "dshot", "duty8"), "throttle"),
    **dict.fromkeys(("N", "mN", "gf"), "thrust"),
}

SI = {dimension: next(iter(units)) for dimension, units in UNITS.items()}

# A sensor's or counter's own steps, which only the mapping's `scale` makes SI.
for _dimension in UNITS.keys() - {"time", "number"}:
    UNITS[_dimension]["counts"] = (1.0, 0.0)


def conversion(dimension: str, unit: str) -> tuple[float, float]:
    """(factor, offset) to SI. KeyError with the known names where `unit` is none of the dimension's."""
    units = UNITS[dimension]
    if unit not in units:
        raise KeyError(f"unit {unit!r} is no unit of {dimension}; known: {', '.join(units)}")
    return units[unit]
