"""What to do after a diagnosis, as commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from infotraj.comparing.following import measuring_command
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS
from infotraj.suggested import again, quoted, unused

_DIGITS = 5e-4  # of a number: less is not seen in the table
_WHY_OTHERWISE = "the table's are found with every number of the file free, the model's with only what it corrects free"
_SCALE = "a scale says whether it is the mass"
OTHERS = "these flights were fitted; others in their place are the real test"


def lines(found: Diagnosis, model: Path, saved: Path | None) -> list[str]:
    """What to do next, a line each. saved: where the new model was written, if it was."""
    told = (weighing(found), flight_command(found, model))
    tells = [f"what these flights cannot tell: {x}" for x in told if x is not None]
    others = [OTHERS] if compares(found, saved) else []
    apart = written_otherwise(found) if saved is not None else []
    fitted = [f"{saved} has other numbers than the table for {', '.join(apart)}: {_WHY_OTHERWISE}"] if apart else []
    return [*fitted, f"next: {next_command(found, model, saved)}", *others, *tells]


def written_otherwise(found: Diagnosis) -> list[str]:
    """Names of effects that the new model has with other numbers than their findings, to the digits that are told."""
    said = {f.name: [f.parameters, *f.instances] for f in found.findings if f.parameters}
    apart = []
    for effect in found.model.effects:
        own = effect.values
        if effect.name in said and not any(
            all(np.allclose(own[k], v, rtol=_DIGITS, atol=0.0) for k, v in numbers.items() if v is not None)
            for numbers in said[effect.name]
        ):
            apart.append(effect.name)
    return list(dict.fromkeys(apart))


def compares(found: Diagnosis, saved: Path | None) -> bool:
    """Whether the command that comes next compares the new model with the one as given, on the flights of the fit."""
    told = bool(found.supported or found.beside) and found.healthy is None
    return saved is not None and told and measured(found)


def measured(found: Diagnosis) -> bool:
    """Whether these flights hold a measured force or torque, not poses alone: else no error can be shown."""
    return bool(found.before.rows.any())


def next_command(found: Diagnosis, model: Path, saved: Path | None) -> str:
    """The command that comes next. saved: where the new model was written, if it was."""
    given, named = quoted(model), quoted(*sources(found))
    new = (found.supported or found.beside) and found.healthy is None
    if not measured(found) and (not new or saved is not None):
        return measuring_command([s.flight for s in found.samples], model)
    if not new:
        name, words = "locate", f"{given} {named}"
    elif saved is None:
        name, words = "diagnose", f"{given} {named} --save-model {unused('new.yaml')}"
    else:
        name, words = "compare", f"{quoted(saved)} {named} --against {given}"
    options = again(name, command_steps=found.command_steps, reference=healthy_sources(found))
    return f"infotraj {name} {words}{options}{force_option(found.by_velocity and name != 'diagnose')}"


def force_option(by_velocity: bool) -> str:
    """What a comparison needs to tell forces from the velocity, too."""
    return " --force-from velocity" if by_velocity else ""


def recording_command(found: Diagnosis, model: Path, saved: Path | None) -> str:
    """The command that records the worst flight: with the new model and the one that it is held against (the one as
    given, or that of the healthy flights), where there is a new one. saved: where it was written, if it was."""
    given, named = quoted(model), quoted(*sources(found))
    if compares(found, saved):
        name, words = "compare", f"{quoted(saved)} {named} --against {given}"
    else:
        name, words = "compare" if found.after is found.before else "diagnose", f"{given} {named}"
    options = again(name, command_steps=found.command_steps, reference=healthy_sources(found))
    options += force_option(found.by_velocity and name != "diagnose")
    return f"infotraj {name} {words} --recording {unused('worst.rrd')}{options}"


def weighing(found: Diagnosis) -> str | None:
    """What tells a mass from a thrust, which no flight does; None where that is no question."""
    group = next((g for g in _groups(found) if _weighed(g)), ())
    if not group:
        return None
    which = " from ".join(group)
    why = "no flight tells a mass from a thrust, for what the rotors push is not measured"
    return f"{which}; {why}; weigh the vehicle: {_SCALE}"


def _weighed(group: tuple[str, ...]) -> bool:
    """Whether a scale tells of a group what flights do not: which is the mass, and which a thrust."""
    return "mass_offset" in group and set(group) <= OF_THRUST_OVER_MASS


def _groups(found: Diagnosis) -> list[tuple[str, ...]]:
    """The groups of what these flights cannot tell apart."""
    return [f.group for f in found.findings if f.verdict == "Not separable"]


def flight_command(found: Diagnosis, model: Path) -> str | None:
    """The command that designs the flight which tells what these could not; None where they could tell everything."""
    group = next((g for g in _groups(found) if not _weighed(g)), ())
    open_questions = bool(group) or any(f.verdict == "Plausible" and not f.of_file for f in found.findings)
    if not found.judged or found.healthy is not None or not open_questions:
        return None
    asked = f" --separate {group[0]} {group[1]}" if group else ""
    flown = f"--flown {quoted(*sources(found))}{asked}{again('design', command_steps=found.command_steps)}"
    return f"infotraj design {quoted(model)} {flown} -o {unused('next.csv')}"


def healthy_sources(found: Diagnosis) -> list[str]:
    """The files of the healthy flights that were used."""
    return [] if found.healthy is None else [str(f.meta.get("source", "flight")) for f in found.healthy.flights]


def sources(found: Diagnosis) -> list[str]:
    """The files of the flights that were used."""
    return [str(s.flight.meta.get("source", "flight")) for s in found.samples]
