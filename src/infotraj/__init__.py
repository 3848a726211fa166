"""infotraj: what is missing in a robot's model, and the flights that teach it."""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"
_FROM_PYTHON = ("compare", "diagnose", "import_log", "load_model", "locate", "read_flight", "save_model")


def __getattr__(name: str) -> Any:
    # By name and late: `import infotraj` loads nothing, and no stage's fingerprint holds what only a notebook uses.
    if name not in _FROM_PYTHON:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.api"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_FROM_PYTHON])
