"""What would mend a finding on import, as the command that does it: `infotraj import LOG --set CHANNEL.KEY=VALUE`."""

from __future__ import annotations

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.dynamics.inputs import SURPLUS
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY
from infotraj.rotations import Array
from infotraj.suggested import quoted

CHANNEL_OF = {
    POSITION: "position",
    ATTITUDE: "attitude",
    VELOCITY: "velocity",
    RATE: "rate",
    SPECIFIC_FORCE: "specific_force",
}


def command(settings: tuple[str, ...]) -> str:
    """The import that applies the settings, as a shell takes it."""
    return " ".join(["infotraj import LOG", *(f"--set {quoted(s)}" for s in settings), "-o NEW.parquet"])


# What `import --fix` cannot find, since it knows no vehicle.
_OF_VEHICLE = ("rotor_unit", "command_unit", SURPLUS)


def mended_by_fix(finding: Finding) -> bool:
    """Whether `infotraj import LOG --fix` sets what the finding asks for."""
    return bool(finding.settings) and finding.code not in _OF_VEHICLE


def remedy_of(finding: Finding) -> str:
    """What to do, as people are told it: `--fix` first, where it does, and the settings beside it."""
    remedy = finding.remedy.rstrip(".")
    if not mended_by_fix(finding):
        return remedy
    options = " ".join(f"--set {quoted(s)}" for s in finding.settings)
    return remedy.replace(f" {options} -o NEW.parquet", f" --fix -o NEW.parquet (or {options})")


def of_log(remedy: str, source: str) -> str:
    """The remedy with the log's own name in its command, so that it can be given as it stands."""
    return remedy.replace("infotraj import LOG ", f"infotraj import {quoted(source)} ")


def by_mapping(remedy: str, mapping: str) -> str:
    """The remedy with the mapping that the log was read with in its command."""
    return remedy.replace("infotraj import LOG ", f"infotraj import LOG --mapping {quoted(mapping)} ")


def axes_setting(channel: str, axes: Array) -> str:
    """The setting for a channel that was declared as `axes` (3, 3) times its true value: a signed permutation."""
    along = []
    for column in axes.T:
        k = int(np.argmax(np.abs(column)))
        along.append(("-" if column[k] < 0 else "") + "xyz"[k])
    return f"{channel}.axes=[{', '.join(along)}]"


def scale_setting(channel: str, times: float) -> str:
    """The setting for a channel that is `times` too large."""
    return f"{channel}.scale={1 / times:.6g}"


def shift_setting(channel: str, late: float) -> str:
    """The setting for a channel that is stamped `late` (s)."""
    return f"{channel}.shift={-late:.4f}"
