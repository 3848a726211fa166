"""From the files that a command names to a diagnosis: what is read, let in, and asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click

from infotraj.comparing import files
from infotraj.diagnosis.diagnosis import Diagnosis, diagnose
from infotraj.diagnosis.gates.level import as_level
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.report.parts import SECONDS, parts
from infotraj.diagnosis.report.saving import save_diagnosed
from infotraj.errors import UsageError, problem
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.models.content import ModelFile
from infotraj.models.file import read_model
from infotraj.options import Reading


@dataclass(frozen=True)
class Asked:
    """A question as its command put it.

    model: the file; read, content: the model and what its file holds; flights, healthy: those that were let in; checks:
    the findings about all flights that were asked about, let in or not.
    """

    model: Path
    read: Model
    content: ModelFile
    flights: files.Admitted[None]
    healthy: list[Flight]
    effects_from: tuple[Path, ...]
    start: float | None
    stop: float | None

    def answer(self, *, matters: float, seed: int) -> Diagnosis:
        """The diagnosis of these flights."""
        return diagnose(
            self.read,
            self.flights.flights,
            effects_from=self.effects_from,
            matters=matters,
            seed=seed,
            start=self.start,
            stop=self.stop,
            reference=self.healthy,
        )

    def save(self, found: Diagnosis, path: Path) -> bool:
        """Writes the model with what is supported; False, and nothing is written, where no axis could be judged."""
        if found.judged:
            save_diagnosed(
                found,
                path,
                parent=self.model,
                content=self.content,
                flights=self.flights.flights,
                start=self.start,
                stop=self.stop,
            )
        return found.judged


def ask(
    model: Path,
    flights: Sequence[Path],
    reference: Sequence[Path],
    *,
    save_model: Path | None,
    effects_from: tuple[Path, ...],
    reading: Reading,
    seconds: float = SECONDS,
) -> Asked:
    """Reads a model and flights and lets in what can be used; of flights longer than `seconds` together a part.

    UsageError, InputError: in one line what cannot be.
    """
    start, stop = reading.start, reading.stop
    files.require_order(start, stop)
    if reference and save_model is not None:
        what = "--save-model with --reference: a change is told from healthy flights, not from the model"
        raise UsageError(problem(what, "one of them", "Leave one out; `infotraj add` fits an effect to flights."))
    read, content = read_model(model, effects_from)
    use = usable(read, start, stop, bool(reference))

    def admitted(paths: Sequence[Path], seen: dict[str, str]) -> files.Admitted[None]:
        let_in = files.admitted(paths, read.vehicle, use, reading, seen)
        used, cut = parts(let_in.flights, seconds, start, stop)
        for line in cut:
            click.echo(line, err=True)
        return replace(let_in, flights=used)

    let_in, healthy = files.apart(flights, reference, admitted)
    return Asked(model, read, content, let_in, healthy.flights, effects_from, start, stop)


def usable(model: Model, start: float | None, stop: float | None, level: bool = False) -> Callable[[Flight], None]:
    """What a flight must pass beyond `check` to be diagnosed: InputError says why it cannot be.

    level: a vehicle whose log does not say so may be taken as level.
    """

    def use(flight: Flight) -> None:
        observe(model, [as_level(flight) if level else flight], start, stop)

    return use
