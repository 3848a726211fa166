"""Where the public data sets lie: the folder named by INFOTRAJ_DATA, else the config's `data_dir`."""

from __future__ import annotations

import os
from pathlib import Path

from infotraj.errors import InputError, problem

VARIABLE = "INFOTRAJ_DATA"


def find_dataset(name: str, data_dir: str | Path | None = None) -> Path | None:
    """The folder of the data set `name`, or None where it is not on this machine.

    INFOTRAJ_DATA wins over `data_dir`; both name the folder that holds one folder a data set.
    """
    for root in (os.environ.get(VARIABLE), data_dir):
        if root:
            folder = Path(root).expanduser() / name
            return folder if folder.is_dir() else None
    return None


def how_to_get(name: str) -> str:
    """One line for whoever lacks the data set `name`."""
    return (
        f"data set {name} is not here: run `infotraj data get {name}`, or set {VARIABLE} to the folder that holds it."
    )


def dataset(name: str, data_dir: str | Path | None = None) -> Path:
    """As find_dataset; InputError where the data set is not on this machine."""
    folder = find_dataset(name, data_dir)
    if folder is None:
        searched = os.environ.get(VARIABLE) or data_dir or f"neither {VARIABLE} nor data_dir is set"
        raise InputError(
            problem(
                f"no data set {name} ({searched})",
                f"a folder {name} under {VARIABLE} or the config's data_dir",
                f"Run `infotraj data get {name}`.",
            )
        )
    return folder
