"""A dropped ROS 2 bag: its files come one by one, its metadata first, and become one folder once all are there."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from infotraj.app.folder import Folder, is_bag, safe_name
from infotraj.errors import UsageError, problem

METADATA = "metadata.yaml"
_PARTS = (".mcap", ".db3", ".yaml")


class DroppedBag:
    """What has come of one bag, in `place`, a folder of the server's own."""

    def __init__(self, place: Path) -> None:
        self.place = place

    @property
    def size(self) -> int:
        """Bytes that have come."""
        return sum(p.stat().st_size for p in self.place.iterdir()) if self.place.is_dir() else 0

    def named(self, name: str) -> str:
        """The name of a file of a bag. UsageError where it has none, or where the metadata could not name it."""
        if safe_name(name, _PARTS) != name:
            what = f"a bag's file {name[:100]!r}"
            raise UsageError(problem(what, "letters, digits, . _ and -", "Put the bag into the folder yourself."))
        return name

    def take(self, part: Path, name: str) -> None:
        """One file more, of a name from `named`; the metadata begin a new bag."""
        if name == METADATA:
            self.drop()
            self.place.mkdir()
        elif not (self.place / METADATA).is_file():
            raise UsageError(problem(f"{name} without its {METADATA}", f"{METADATA} first", "Drop the bag's folder."))
        os.replace(part, self.place / name)

    def into(self, folder: Folder, name: str) -> str:
        """Its name in the folder, one that was free. UsageError where it is no bag."""
        if not is_bag(self.place):
            self.drop()
            raise UsageError(problem(f"{name[:100]}: no bag", f"{METADATA} and its .mcap or .db3", "Drop all of it."))
        return folder.take_folder(self.place, name).name

    def drop(self) -> None:
        """Forgets what has come."""
        shutil.rmtree(self.place, ignore_errors=True)
