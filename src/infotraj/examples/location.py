"""Where the shipped files lie: inside an installed package, at the top of a checkout."""

from __future__ import annotations

from pathlib import Path

from infotraj.errors import InfotrajError, problem

_HERE = Path(__file__).resolve().parent
# What is shipped: its name, and its folder in a checkout. setup.py puts them beside this file when a wheel is built.
FOLDERS = {"quad": "examples/quad", "vehicles": "config/vehicles"}


def shipped(name: str) -> Path:
    """The folder of what is shipped under `name`, a key of FOLDERS. InfotrajError where it was not installed."""
    for folder in (_HERE / name, _HERE.parents[2] / FOLDERS[name]):
        if folder.is_dir():
            return folder
    raise InfotrajError(problem(f"no {name} beside infotraj", "a complete installation", "Install it again."))
