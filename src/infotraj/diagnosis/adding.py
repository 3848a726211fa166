"""Adds named effects to a model, fitted to flights, whether the flights need them or not; the file is corrected as in
the model that `diagnose` gives, but for products of inertia."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from infotraj.arguments import AnyPath
from infotraj.checking.acceptance import accepted_in, accepted_lines
from infotraj.comparing.equation_error import AXES
from infotraj.comparing.statistics import Statistics
from infotraj.comparing.summary import errors_by_axis
from infotraj.diagnosis.diagnosis import held_members
from infotraj.diagnosis.gates import refusal
from infotraj.diagnosis.gates.accelerometer import unshaken
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.judge.giving import given
from infotraj.diagnosis.judge.numbers import fitted_numbers, number_in_words
from infotraj.diagnosis.judge.worse import worse_lines
from infotraj.diagnosis.linear.candidates import candidates
from infotraj.diagnosis.select.bounds import below_file, beyond_bounds
from infotraj.diagnosis.select.fit import Fit
from infotraj.diagnosis.select.prior import file_only, is_file_number
from infotraj.diagnosis.select.reading import as_commanded
from infotraj.diagnosis.select.search import Search
from infotraj.diagnosis.select.swinging import swung
from infotraj.dynamics.inputs import for_vehicle
from infotraj.effects import catalogue, effect_class, labels_in_words
from infotraj.effects.registry import OF_THE_FILE
from infotraj.errors import InputError, UsageError, problem
from infotraj.flight import Flight, command_steps
from infotraj.models import Model
from infotraj.progress import parts, reached

# % of what follows the first columns: means over six sets of 3 to 6 flights on 26 November 2026, each within 15 of it.
_PARTS = {"fitting": 50.0, "the new model": 13.0, "the file's numbers": 32.0, "errors": 5.0}


@dataclass(frozen=True)
class Added:
    """A model with effects added: their names, standard errors of all its effects, equation error before and after.

    ended: effects whose numbers stopped at a bound, and how; command_steps: that commands were taken to make
    from row to row, 1 where they were held; accepted: findings about the flights that the user overruled; beside:
    labels of effects that nobody asked for and that correct the file, last in the model; notes: what a reader must
    know.
    """

    model: Model
    names: tuple[str, ...]
    errors: tuple[dict[str, Any], ...]
    before: Statistics
    after: Statistics
    ended: dict[str, str]
    command_steps: int = 1
    accepted: tuple[dict[str, Any], ...] = ()
    beside: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """JSON: effects with parameters and standard errors, what corrects the file apart; errors before and after."""
        every = [
            {"name": e.name, "parameters": e.values, "standard_errors": s}
            for e, s in zip(self.model.effects, self.errors, strict=True)
        ]
        own = len(every) - len(self.beside)
        return {
            "effects": every[:own],
            "corrected": every[own:],
            "error": errors_by_axis(self.before, self.after),
            "commands": {"steps": self.command_steps},
            "at_bound": self.ended,
            "accepted": list(self.accepted),
            "warnings": list(self.notes),
        }

    def as_text(self) -> str:
        """A line an effect, one of what corrects the file, then a line an axis, and what is worse."""
        lines = []
        for e, s in zip(self.model.effects, self.errors, strict=True):
            said = f"{e.name}: {', '.join(number_in_words(k, v, s.get(k)) for k, v in e.values.items())}"
            if e.label not in self.beside:
                lines.append(said)
            elif len(self.beside) == 1:
                lines.append(f"{said}; it corrects the file")
        if len(self.beside) > 1:
            lines.append(f"these correct the file, and predict together: {labels_in_words(self.beside)}")
        for label, how in self.ended.items():
            lines.append(f"WARNING {label}: {how} (no measured number: the truth may lie beyond)")
        for i, axis in enumerate(AXES):
            if self.before.rmse[i] == self.before.rmse[i]:
                after = f"{self.after.rmse[i]:.4g} after, floor {self.after.floor[i]:.4g}"
                lines.append(f"{axis}: {self.before.rmse[i]:.4g} before, {after}")
        lines += worse_lines(self.before, self.after).values()
        if self.command_steps > 1:
            lines.append(f"commands: read as {self.command_steps} steps from row to row")
        lines += [f"warning: {note}" for note in self.notes]
        return "\n".join([*lines, *accepted_lines(self.accepted)]) + "\n"


def add(
    model: Model,
    names: Sequence[str],
    flights: Sequence[Flight],
    *,
    effects_from: AnyPath | Iterable[AnyPath] = (),
    start: float | None = None,
    stop: float | None = None,
) -> Added:
    """Fits the effects `names` (with `:3` for a place in a list) together with those of the model.

    UsageError for a name that does not exist; InputError where the flights cannot show an effect.
    """
    vehicle = model.vehicle
    flights = [for_vehicle(f, vehicle) for f in flights]
    catalog = catalogue(effects_from)
    for name in names:
        effect_class(name.split(":")[0], effects_from)
        if name.split(":")[0] in OF_THE_FILE:
            what = f"{name} is a number of the vehicle file, which is corrected along"
            raise UsageError(problem(what, "an effect (`infotraj effects`)", "Drop it."))
    flights, notes = unshaken(model, flights, start, stop)
    known, hidden = candidates(catalog, vehicle, flights)
    chosen = []
    for name in names:
        plain, _, place = name.partition(":")
        if plain in hidden:
            raise InputError(problem(f"{plain} cannot be fitted: {hidden[plain]}", "flights that show it", "Drop it."))
        options = [c for c in known if c.name == plain and (not place or str(dict(c.fixed).get("rotor")) == place)]
        if not options or (options[0].fixed and not place):
            there = ", ".join(c.label.replace(" ", ":") for c in known if c.name == plain)
            raise UsageError(problem(f"{name}: which one", f"one of {there}", "Correct it."))
        chosen.append(options[0])
    held = held_members(model, flights[0])
    taken = {m.candidate.label for m in held}
    twice = [c.label for c in chosen if c.label in taken]
    if twice:
        raise UsageError(problem(f"{twice[0]} is in the model already", "an effect that is not", "Drop it."))
    inside = {c.label for c in (*chosen, *(m.candidate for m in held))}
    beside = [c for c in (*known, *file_only(vehicle, known, flights)) if is_file_number(c) and c.label not in inside]
    every = (*chosen, *beside)
    first = swung(as_commanded(observe(model, flights, start, stop), held, every), every)
    search = Search(first.observation, every, held)
    asked = [c.label for c in chosen]
    parts(_PARTS)
    found = search.named(first, asked)
    made, corrects = _given(search, found, asked)
    # Beside a file that is taken as exact every number would be too sure.
    numbers = {
        m.candidate.label: n for f in (made, found) for m, n in zip(f.members, fitted_numbers(f, found), strict=True)
    }
    reached("errors")
    # As they stand in the model, then as they were asked for, then what corrects the file.
    order = [*asked, *corrects]
    members = sorted(made.members, key=lambda m: -1 if m.held else order.index(m.candidate.label))
    new = Model(vehicle, [m.effect for m in members])
    read = search.observation.flights  # with their commands as they were read
    return Added(
        new,
        tuple(names),
        tuple(numbers[m.candidate.label] for m in members),
        refusal.errors(model, read, start, stop),
        refusal.errors(new, read, start, stop),
        {x: f"{how}; something else is missing" for x, how in beyond_bounds(made.members, vehicle).items()}
        | below_file([m for m in made.members if m.candidate.label in asked], vehicle),
        max(command_steps(s.flight) for s in search.observation.samples),
        (*accepted_in(flights), *(d.as_dict() for d in notes if d.accepted)),
        tuple(corrects),
        tuple(d.reason for d in notes if not d.accepted),
    )


def _given(search: Search, found: Fit, asked: Sequence[str]) -> tuple[Fit, tuple[str, ...]]:
    """The model that is given of what was found beside the file's own errors, as `diagnose` gives it, and labels of
    what corrects the file in it. What was asked for stays whole, even where flights are predicted worse for it."""
    made = given(search, found, asked)
    if not (made.lost or made.held_back.keys() & set(asked)):
        return made.fit, made.beside
    return search.fitted([*asked, *made.beside], found, made.fit.scales, go_on=True), made.beside
