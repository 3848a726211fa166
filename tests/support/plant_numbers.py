"""Measures what docs/plants.md says of the plants. Not a test: the flights take a minute.

usage: python tests/support/plant_numbers.py      prints the lines and the table of that page
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from infotraj import rotations
from infotraj.control.tracking import TrackingController
from infotraj.experiment.hidden.config import read_study
from infotraj.robots.plant import residual_table
from infotraj.robots.plant.aerodynamics import blade_table
from infotraj.robots.plant.blade_elements import balanced
from infotraj.robots.plant.hiding import hide
from infotraj.robots.plant.plant import Plant
from infotraj.robots.plant.sensors import Noise
from infotraj.robots.plant.static import StaticPlant
from infotraj.robots.plant.truth import Interference, Truth, load_truth
from infotraj.trajectories.reference import Reference, from_poses
from infotraj.trajectories.standard import Extent, standard
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")
AGILE = load_vehicle("config/vehicles/agile_quadrotor.yaml")
STEPS, FINEST = (2.5e-3, 1e-3, 0.5e-3), 0.25e-3  # s
POSITION, ATTITUDE = ["px", "py", "pz"], ["qw", "qx", "qy", "qz"]


def truth(letter: str) -> Truth:
    return load_truth(f"config/plants/omav_{letter}.yaml", OMAV)


def without_interference() -> str:
    """The greatest torque that an affine function of the force leaves where no wake meets a rotor, of all plants."""
    left = []
    for hidden in map(truth, "abcdef"):
        air = hidden.air.model_copy(update={"interference": Interference()})
        plant = StaticPlant(OMAV, hidden.model_copy(update={"air": air}))
        left.append(np.abs(residual_table.after_affine_fit(residual_table.held_hovers(plant))).max())
    return f"at most {max(left):.4f} N m"


def rotor_of_blades() -> list[str]:
    """A rotor of the agile quadrotor at its hover speed: thrust over the square of the air across it, H-force and
    rolling moment over that air and the speed, at 2 and at 18 m/s."""
    values = read_study("config/studies/hidden_effects.yaml").vehicles["agile_quadrotor"].richer["blade_elements"]
    blade, rotor = blade_table(hide(AGILE, [("blade_elements", values.parameters)]))[0], AGILE.rotors[0]
    assert rotor.thrust_coefficient is not None
    hover = float(np.sqrt(AGILE.known_mass() * AGILE.gravity / len(AGILE.rotors) / rotor.thrust_coefficient))

    def loaded(across: float) -> np.ndarray:
        out = np.empty(6)
        balanced(blade, rotor.radius, hover, across, 0.0, np.zeros(2), 6.0, out)
        return out

    still, speeds = loaded(0.0), (2.0, 18.0)
    return [
        " and ".join(f"{(loaded(v)[2] - still[2]) / v**2:.1e}" for v in speeds) + " N s^2/m^2",
        " and ".join(f"{loaded(v)[0] / (hover * v):.1e}" for v in speeds) + " N s^2/(m rad)",
        " and ".join(f"{loaded(v)[3] / (hover * v):.1e}" for v in speeds) + " N m s^2/(m rad)",
    ]


def estimator_errors() -> str:
    """Rms of the estimate's error an axis, over two references of 20 s on omav_a to omav_c (attitude: of the angle)."""
    gone: list[list[float]] = []
    for letter in "abc":
        for kind in ("attitude", "waypoints"):
            extent = Extent(size=0.5, speed=0.5, tilt=0.5)
            reference = standard(kind, 20.0, extent, np.random.default_rng(1))
            plant, controller = Plant(OMAV, truth(letter)), TrackingController(OMAV, reference)
            flight, true = plant.fly_with_truth(reference, controller, np.random.default_rng(2))
            place = flight.get("est_px", "est_py", "est_pz") - true[POSITION].to_numpy()
            speed = flight.get("est_vx", "est_vy", "est_vz") - true[["vx", "vy", "vz"]].to_numpy()
            estimated = flight.get("est_qw", "est_qx", "est_qy", "est_qz")
            turn = rotations.angle_between(estimated, true[ATTITUDE].to_numpy())
            gone.append([float(np.mean(x**2)) for x in (1e3 * place, np.degrees(turn), 1e3 * speed)])
    place_mm, turn_deg, speed_mm = np.sqrt(np.mean(gone, axis=0))
    return f"{place_mm:.1f} mm, {turn_deg:.2f} deg and {speed_mm:.0f} mm/s"


def pitch(seconds: float = 10.0, angle: float = np.radians(60)) -> Reference:
    """There and back in place, as a raised cosine."""
    t = np.arange(0.0, seconds, 0.01)
    turned = 0.5 * angle * (1 - np.cos(2 * np.pi * t / seconds))
    return from_poses(t, np.tile([0.3, -0.2, 1.0], (len(t), 1)), rotations.from_euler(0 * t, turned, 0 * t))


def time_steps() -> list[str]:
    """Rows of the page's table: differences to the finest step, without sensor noise."""
    reference = pitch()

    def flown(letter: str, step: float) -> pd.DataFrame:
        plant = Plant(OMAV, truth(letter), timestep=step, noise=Noise(0.0, 0.0, 0.0, 0.0))
        return plant.fly_with_truth(reference, TrackingController(OMAV, reference), np.random.default_rng(0))[1]

    finest, rows = {letter: flown(letter, FINEST) for letter in "abc"}, []
    for step in STEPS:
        place, turn, torque = [], [], []
        for letter, best in finest.items():
            found = flown(letter, step)
            place.append(1e3 * np.linalg.norm((found - best)[POSITION].to_numpy(), axis=1).max())
            angle = rotations.angle_between(found[ATTITUDE].to_numpy(), best[ATTITUDE].to_numpy())
            turn.append(np.degrees(angle.max()))
            torque.append(np.sqrt(np.mean((found - best)[["tx", "ty", "tz"]].to_numpy() ** 2)))
        columns = (place, ".1f"), (turn, ".2f"), (torque, ".4f")
        cells = [", ".join(f"{x:{digits}}" for x in column) for column, digits in columns]
        rows.append(f"| {1e3 * step:g} | " + " | ".join(cells) + " |")
    return rows


if __name__ == "__main__":
    print("\n".join([without_interference(), *rotor_of_blades(), estimator_errors(), *time_steps()]))
