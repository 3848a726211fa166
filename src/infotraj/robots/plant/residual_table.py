"""The size of each plant's residual against tilt, beside the numbers that were seen on the real vehicle.

python -m infotraj.robots.plant.residual_table      writes docs/plants.md between its two markers
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from infotraj.errors import InputError, problem
from infotraj.robots.plant.static import StaticPlant
from infotraj.robots.plant.truth import load_truth
from infotraj.rotations import Array
from infotraj.vehicle import load_vehicle
from infotraj.writing import write_text

TILTS = np.radians(np.arange(0.0, 61.0, 10.0))
AZIMUTHS = np.radians(np.arange(0.0, 360.0, 45.0))
BEGIN, END = "<!-- residual table: begin -->", "<!-- residual table: end -->"

# What the experiment's specification quotes from the real vehicle, in the order of `Summary`.
SPEC = {
    "level": (0.10, 0.35),
    "growth": (0.30, 0.40),
    "after_affine": (0.06, 0.09),
    "deficit_level": (0.04, 0.06),
    "deficit_tilted": (0.08, 0.12),
}
LABELS = {
    "level": "level: norm of the residual torque (N m)",
    "growth": "growth from level to 60 deg (N m), rms over azimuths",
    "after_affine": "left after an affine fit in the force (N m), rms of the norm",
    "deficit_level": "thrust deficit, level",
    "deficit_tilted": "thrust deficit, mean at 50 and 60 deg",
}
QUOTED = {
    "level": "0.1 to 0.35",
    "growth": "0.3 to 0.4",
    "after_affine": "0.06 to 0.09",
    "deficit_level": "5 %",
    "deficit_tilted": "10 %",
}


@dataclass(frozen=True)
class Residual:
    """Held hovers over TILTS x AZIMUTHS: command (tilts, azimuths, 6) N and N m, residual torque (.., 3) N m and
    thrust deficit (tilts, azimuths), the share of the commanded force that does not carry the weight."""

    command: Array
    torque: Array
    deficit: Array


@dataclass(frozen=True)
class Summary:
    """The five numbers of the specification (N m, and shares for the deficits)."""

    level: float
    growth: float
    after_affine: float
    deficit_level: float
    deficit_tilted: float


def held_hovers(plant: StaticPlant) -> Residual:
    """Holds the true vehicle at every tilt and azimuth of its world z axis in the body frame.

    In such a hover the achieved torque is zero, so the residual (achieved minus commanded torque) is minus the
    commanded one.
    """
    command = np.empty((len(TILTS), len(AZIMUTHS), 6))
    torque = np.empty((len(TILTS), len(AZIMUTHS), 3))
    deficit = np.empty((len(TILTS), len(AZIMUTHS)))
    weight = plant.vehicle.known_mass() * plant.vehicle.gravity
    for i, tilt in enumerate(TILTS):
        for j, azimuth in enumerate(AZIMUTHS):
            up = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
            command[i, j] = plant.hold(up)
            torque[i, j] = plant.achieved(command[i, j])[3:] - command[i, j, 3:]
            deficit[i, j] = 1.0 - weight / np.dot(up, command[i, j, :3])
    return Residual(command, torque, deficit)


def after_affine_fit(residual: Residual) -> Array:
    """What an affine function of the commanded force leaves of the residual torque, (tilts, azimuths, 3) N m."""
    force = residual.command[..., :3].reshape(-1, 3)
    torque = residual.torque.reshape(-1, 3)
    features = np.column_stack([np.ones(len(force)), force])
    coefficients, *_ = np.linalg.lstsq(features, torque, rcond=None)
    return (torque - features @ coefficients).reshape(residual.torque.shape)


def rms_norm(vectors: Array, axis: int | tuple[int, ...]) -> Array:
    """Root mean square over `axis` of the Euclidean norm of the vectors on the last axis."""
    return np.sqrt(np.mean(np.sum(vectors**2, axis=-1), axis=axis))


def summary(residual: Residual) -> Summary:
    """The specification's five numbers for one plant."""
    grown = residual.torque[-1] - residual.torque[0]
    return Summary(
        level=float(np.linalg.norm(residual.torque[0, 0])),
        growth=float(rms_norm(grown, axis=0)),
        after_affine=float(rms_norm(after_affine_fit(residual), axis=(0, 1))),
        deficit_level=float(residual.deficit[0].mean()),
        deficit_tilted=float(residual.deficit[-2:].mean()),
    )


def table(vehicle_path: Path, truth_paths: list[Path]) -> str:
    """The Markdown of docs/plants.md between its markers."""
    vehicle = load_vehicle(vehicle_path)
    residuals = {p.stem: held_hovers(StaticPlant(vehicle, load_truth(p, vehicle))) for p in truth_paths}
    names = list(residuals)
    summaries = {n: summary(r) for n, r in residuals.items()}
    lines = ["| | real vehicle | " + " | ".join(names) + " |", "|---" * (len(names) + 2) + "|"]
    for key, label in LABELS.items():
        cells = [
            f"{100 * getattr(summaries[n], key):.1f} %" if "deficit" in key else f"{getattr(summaries[n], key):.3f}"
            for n in names
        ]
        lines.append(f"| {label} | {QUOTED[key]} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "Root mean square over the azimuths of the residual torque (x, y, z; N m), and the thrust deficit:",
        "",
    ]
    lines += ["| tilt (deg) | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for i, tilt in enumerate(TILTS):
        cells = []
        for n in names:
            x, y, z = np.sqrt(np.mean(residuals[n].torque[i] ** 2, axis=0))
            cells.append(f"{x:.3f}, {y:.3f}, {z:.3f}; {100 * residuals[n].deficit[i].mean():.1f} %")
        lines.append(f"| {np.degrees(tilt):.0f} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def write_table(page: Path, content: str) -> None:
    """Puts `content` between the markers of `page`. InputError where the page or a marker is missing."""
    text = page.read_text() if page.is_file() else ""
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        raise InputError(problem(f"{page}: no place for the table", f"one line {BEGIN} and one {END}", "Add them."))
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    write_text(f"{before}{BEGIN}\n{content}\n{END}{after}", page)


def main() -> None:
    """Command line: writes the table of the given truth files into a page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--vehicle", type=Path, default=Path("config/vehicles/omav.yaml"))
    parser.add_argument("--page", type=Path, default=Path("docs/plants.md"))
    plants = [Path(f"config/plants/omav_{letter}.yaml") for letter in "abcdef"]
    parser.add_argument("truth", type=Path, nargs="*", default=plants)
    arguments = parser.parse_args()
    write_table(arguments.page, table(arguments.vehicle, arguments.truth))


if __name__ == "__main__":
    main()
