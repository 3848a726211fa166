"""The corpus's real flights: which files of which public data sets, and which findings are right in them."""

from __future__ import annotations

from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path

from pydantic import Field

from infotraj.checking import load
from infotraj.datasets.location import find_dataset
from infotraj.experiment.common.strict_yaml import Strict, read_yaml
from infotraj.experiment.corpus.recipes import Log, Right
from infotraj.flight import sha256
from infotraj.vehicle import load_vehicle


class RightFinding(Strict):
    """Findings that are right in some files of a data set."""

    files: str = Field(description="a pattern of file names without their ending")
    codes: tuple[str, ...] = Field(min_length=1, description="patterns of codes")
    start: float | None = Field(None, alias="from", description="s; a finding that begins before is none of them")
    why: str


class RealSource(Strict):
    """One data set of real flights."""

    name: str
    folder: str = Field(description="the data set's folder under INFOTRAJ_DATA")
    files: str = Field(description="pattern of its logs")
    mapping: str | None = None
    vehicle: str | None = None
    spoil: int = Field(0, ge=0, description="into how many logs the known errors are put")
    right: tuple[RightFinding, ...] = ()


class RealSources(Strict):
    """All of them."""

    sources: tuple[RealSource, ...]


@dataclass(frozen=True)
class RealRecipe:
    """One real log; `moving`: known errors are put into it."""

    path: Path
    settings: RealSource
    moving: bool = False
    source: str = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "source", self.settings.name)

    def make(self) -> Log:
        """Reads it. InputError where it cannot be imported."""
        loaded = load(self.path, self.settings.mapping)
        name, start = self.path.stem, float(loaded.flight.t[0])
        right = tuple(
            Right(code, None if r.start is None else start + r.start, why=r.why)
            for r in self.settings.right
            if fnmatch(name, r.files)
            for code in r.codes
        )
        vehicle = load_vehicle(self.settings.vehicle) if self.settings.vehicle else None
        folder = find_dataset(self.settings.folder)
        shown = str(self.path.relative_to(folder)) if folder and self.path.is_relative_to(folder) else self.path.name
        return Log(self.source, shown, "rough", loaded, vehicle, right, moving=self.moving)


def read_sources(path: str | Path) -> RealSources:
    """The file of sources (YAML). UsageError, one line, where it cannot be used."""
    return read_yaml(RealSources, path)


def real_recipes(path: str | Path, data_dir: str | None = None) -> tuple[list[RealRecipe], list[str]]:
    """The logs of all data sets that are on this machine, copies left out, and the names of those that are not."""
    recipes: list[RealRecipe] = []
    absent = []
    for source in read_sources(path).sources:
        folder = find_dataset(source.folder, data_dir)
        if folder is None:
            absent.append(source.name)
            continue
        files: dict[str, Path] = {}
        for file in sorted(p for p in folder.glob(source.files) if p.is_file()):
            files.setdefault(sha256(file), file)
        plain = [p for p in files.values() if not any(fnmatch(p.stem, r.files) for r in source.right)]
        # spread over the list: neighbours are repetitions
        chosen = set(plain[:: max(1, len(plain) // source.spoil)][: source.spoil]) if source.spoil else set()
        recipes += [RealRecipe(p, source, p in chosen) for p in files.values()]
    return recipes, absent
