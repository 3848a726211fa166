"""The files that a configuration names: they have to be there before anything is planned."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

from infotraj.errors import UsageError, problem
from infotraj.experiment.common.config import ExperimentConfig


def plant_path(vehicle: str | Path, plant: str) -> Path:
    """The truth of a plant: plants/PLANT.yaml beside the folder of the vehicle file."""
    return Path(vehicle).parent.parent / "plants" / f"{plant}.yaml"


def with_its_files(config: ExperimentConfig, source: str = "config") -> ExperimentConfig:
    """The configuration, once the vehicle, the plants and the cases of the closed loop that it names are there.

    UsageError, one line, for the first that is not. Plants fly with `execution: plant` alone.
    """
    vehicle, loop = Path(config.vehicle), Path(config.closed_loop.folder)
    _there(f"{source}: vehicle", [str(vehicle)], map(str, vehicle.parent.glob("*.yaml")), vehicle.parent)
    if config.execution == "plant":
        plants = plant_path(vehicle, "*").parent
        _there(f"{source}: plants", config.plants, (p.stem for p in plants.glob("*.yaml")), plants)
    cases = (p.parent.name for p in loop.glob("*/truth.yaml") if p.with_name("oracle.yaml").is_file())
    _there(f"{source}: closed_loop.cases", config.closed_loop.cases, cases, loop)
    return config


def _there(where: str, wanted: Iterable[str], found: Iterable[str], folder: Path) -> None:
    known = sorted(found)
    for name in wanted:
        if name not in known:
            near = get_close_matches(name, known, 1)
            raise UsageError(
                problem(
                    f"{where}: {name} is not in {folder}",
                    f"one of {', '.join(known)}" if known else "files there, and there are none",
                    f"Did you mean {near[0]}?" if near else "Correct the name or add its file.",
                )
            )
