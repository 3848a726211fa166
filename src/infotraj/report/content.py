"""All that the page shows, as numbers and sentences that JSON holds: the page is drawn from this alone."""

from __future__ import annotations

import inspect
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from infotraj import __version__
from infotraj.comparing.equation_error import AXES
from infotraj.comparing.following import measuring_command
from infotraj.comparing.summary import by_axis
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.report import summary
from infotraj.diagnosis.report.asking import Asked
from infotraj.diagnosis.report.following import (
    OTHERS,
    compares,
    flight_command,
    healthy_sources,
    measured,
    next_command,
    recording_command,
    sources,
    weighing,
)
from infotraj.diagnosis.report.steps import called, said
from infotraj.effects import catalogue
from infotraj.effects.registry import OF_THE_FILE
from infotraj.flight import sha256
from infotraj.locating.healthy import beside
from infotraj.locating.locating import locate
from infotraj.report import failing, flown
from infotraj.report.again import FORM
from infotraj.report.combinations import Combinations, combinations
from infotraj.report.traces import flight_traces
from infotraj.suggested import again, quoted

_PACKAGES = ("numpy", "scipy", "pandas", "numba", "bokeh")


def gathered(
    asked: Asked, found: Diagnosis, *, seed: int, matters: float, saved: Path | None, command: Sequence[str]
) -> dict[str, Any]:
    """The content of the page. command: the words of the command that asks for it."""
    flights = [s.flight for s in found.samples]
    names = _names([str(f.meta.get("source", f"flight {k}")) for k, f in enumerate(flights)])
    fall = combinations(found, seed)
    how: dict[str, Any] = {"start": asked.start, "stop": asked.stop}
    given = asked.read if found.healthy is None else found.search.observation.model([])
    located = locate(given, flights, rng=np.random.default_rng(seed), **how)
    healthy = beside(located, given, found.healthy.flights, **how) if found.healthy is not None else None
    unit = fall.made[-1].errors[-1].unit
    answer = summary.as_dict(found)
    return {
        "form": FORM,
        "answer": answer,
        "text": summary.as_text(found, verbose=True),
        "effects": _about(asked.effects_from),
        "unit": {axis: unit["force" if axis[0] == "f" else "torque"] for axis in AXES},
        "flights": [
            row | {"name": name} for row, name in zip(flown.flown(found, asked.flights.checks), names, strict=True)
        ],
        "rejected": flown.rejected(asked.flights.checks),
        "questions": flown.covered_questions(),
        "heat": failing.heat(fall, names),
        "places": failing.places(located, healthy),
        "offsets": failing.offsets(located),
        "windows": failing.windows(located, names),
        "filter": fall.made[0].errors[0].filter,
        "fall": _fall(fall, found),
        "traces": flight_traces(fall, names, located.windows),
        "leftover": failing.leftover(fall.made[-1].errors),
        "next": _next(asked, found, saved),
        "provenance": {
            "command": list(command),
            "infotraj": __version__,
            "python": platform.python_version(),
            "packages": {name: version(name) for name in _PACKAGES},
            "model": str(asked.model),
            "model_sha256": sha256(asked.model) if asked.model.is_file() else None,
            "seed": seed,
            "matters": matters,
            "from": asked.start,
            "to": asked.stop,
            "trail": list(found.search.trail),
        },
    }


def _names(paths: Sequence[str]) -> list[str]:
    """Short names of files, longer where two are alike."""
    for parts in range(1, 1 + max(len(Path(p).parts) for p in paths)):
        names = ["/".join(Path(p).with_suffix("").parts[-parts:]) for p in paths]
        if len(set(names)) == len(names):
            return names
    return [f"{k}: {p}" for k, p in enumerate(paths)]


def _about(effects_from: Sequence[Path]) -> dict[str, Any]:
    """What each effect is, and the units of its numbers."""
    return {
        name: {
            "does": (inspect.getdoc(cls) or "").partition("\n")[0],
            "place": cls.place,
            "units": {p.name: p.unit for p in cls.parameters},
            "index": [p.name for p in cls.parameters if p.index],
            "source": cls.source,
        }
        for name, cls in (catalogue(effects_from) | OF_THE_FILE).items()
    }


def _fall(fall: Combinations, found: Diagnosis) -> dict[str, Any]:
    labels = [called(found, group) for group in fall.groups]
    # The steps of the waterfall are the combinations in which boxes are ticked from the first on.
    return {
        "boxes": [
            {"label": label, "effects": list(group), "corrects": group[0] in found.beside}
            for label, group in zip(labels, fall.groups, strict=True)
        ],
        "steps": list(said(labels) if found.healthy is None else ("as healthy", *said(labels)[1:])),
        "at": [2**k - 1 for k in range(len(labels) + 1)],
        "axes": [a for i, a in enumerate(AXES) if np.isfinite(fall.rmse[:, i]).all()],
        "refused": found.refused,
        "rmse": [by_axis(row) for row in fall.rmse],
        "low": [by_axis(row) for row in fall.low],
        "high": [by_axis(row) for row in fall.high],
        "floor": by_axis(fall.floor),
    }


def _next(asked: Asked, found: Diagnosis, saved: Path | None) -> list[dict[str, str]]:
    """What to do next: why, and the command, empty where it is done by hand."""
    model, named = asked.model, f"{quoted(asked.model)} {quoted(*sources(found))}"
    how: dict[str, Any] = {"command_steps": found.command_steps, "reference": healthy_sources(found)}
    rows = []
    shown = measured(found)  # else there is no measured wrench to show
    if (found.supported or found.beside) and found.healthy is None and (shown or saved is None):
        new = "Write the model with what is named" if found.supported else "Write the model with the file corrected"
        why = f"Compare the new model with the one as given ({OTHERS})" if compares(found, saved) else new
        rows.append((why, next_command(found, model, saved)))
    if shown:
        rows.append(("Look at where it fails", f"infotraj locate {named}{again('locate', **how)}"))
    else:
        flights = [s.flight for s in found.samples]
        rows.append(("Have something measured to compare with", measuring_command(flights, model)))
    scale = weighing(found)
    if scale is not None:
        rows.append((f"These flights cannot tell {scale}", ""))
    flight = flight_command(found, model)
    if flight is not None:
        rows.append(("Design the flight that tells what these could not", flight))
    if shown:
        rows.append(("See the worst flight in three dimensions", recording_command(found, model, saved)))
    return [{"why": why, "command": command} for why, command in rows]
