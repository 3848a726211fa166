"""Made-up multirotors from 30 g to 14 kg, by the proportions of two that are published.

Lengths, inertia and rotors in proportion to the Hummingbird's (Furrer et al., RotorS, 2016: 0.716 kg, arms of 0.17 m,
rotors of 0.1 m, k_F 8.55e-6, moment constant 0.016 m) and the Crazyflie's (Foerster, ETH Zurich 2015: 27 g, 46 mm,
23 mm, k_F 2.3e-8), which agree to 30 % in each number below; heavier ones are extrapolated, so assumed.
"""

from __future__ import annotations

import numpy as np

from infotraj.vehicle import Vehicle, parse_vehicle

MASSES = (0.03, 0.25, 0.75, 1.6, 4.5, 14.0)
_AIR = 1.2  # kg/m^3
_GRAVITY = 9.81


def made_vehicle(mass: float, rng: np.random.Generator) -> Vehicle:
    """A vehicle of that mass (kg): four rotors, or six in half of those above 1 kg; each number varies by a tenth."""

    def about(value: float) -> float:
        return float(value * rng.uniform(0.9, 1.1))

    count = 6 if mass > 1.0 and rng.random() < 0.5 else 4
    arm = about(0.19 * mass ** (1 / 3))
    radius = min(about(0.55 * arm), 0.9 * arm * np.sin(np.pi / count))
    # thrust coefficient 0.022 on area and tip speed: k_F = 0.022 x air x pi x radius^4
    k_f = about(0.022 * _AIR * np.pi * radius**4)
    hover = np.sqrt(mass * _GRAVITY / count / k_f)
    moment = about(0.18 * radius)
    lag = float(0.035 * mass ** (1 / 6) * rng.uniform(0.8, 1.5))
    angles = 2 * np.pi * (np.arange(count) + 0.5) / count
    rotors = [
        {
            "name": f"rotor_{k}",
            "position": [float(arm * np.cos(a)), float(arm * np.sin(a)), 0.0],
            "spin": 1 if k % 2 else -1,
            "thrust_coefficient": k_f,
            "moment_constant": moment,
            "max_speed": float(hover * np.sqrt(rng.uniform(2.0, 3.5))),
            "time_constant": lag,
            "radius": radius,
        }
        for k, a in enumerate(angles)
    ]
    inertia = {"xx": about(0.31 * mass * arm**2), "yy": about(0.31 * mass * arm**2)}
    inertia["zz"] = float(rng.uniform(0.83, 0.93)) * (inertia["xx"] + inertia["yy"])  # nearly flat bodies
    return parse_vehicle(
        {"name": f"made_{mass:g}_kg", "mass": mass, "inertia": inertia, "gravity": _GRAVITY, "rotors": rotors}
    )
