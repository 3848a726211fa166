"""One case of real flights: what `diagnose` answers, its CPU time, and the error on flights that were not fitted."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from infotraj.checking.admission import admitted, checked
from infotraj.comparing import compare
from infotraj.comparing.equation_error import equation_error
from infotraj.comparing.files import write_json
from infotraj.comparing.summary import as_dict as compared_as_dict
from infotraj.diagnosis.diagnosis import diagnose
from infotraj.diagnosis.gates.observing import observe
from infotraj.diagnosis.report import summary
from infotraj.diagnosis.report.saving import save_diagnosed
from infotraj.errors import InputError
from infotraj.experiment.real.cases import RealCase, Window, flight_path, read_cases
from infotraj.flight import Flight, read_flight
from infotraj.models import Model, save_model
from infotraj.models.file import read_model
from infotraj.vehicle import Vehicle
from infotraj.writing import write_text


def answer_case(
    *, cases: str | Path, name: str, config: str | Path, flights: str | Path, numbers: str | Path, text: str | Path,
    model: str | Path, seed: int = 0,
) -> None:  # fmt: skip
    """Diagnoses the flights to fit of one case, as `infotraj diagnose --skip-rejected` does, and tests the answer.

    flights: the folder that `cut_case` filled. numbers (JSON): `answer`, the JSON of `diagnose`; `seconds`, CPU time of
    the diagnosis alone; `held_out`, the JSON of `compare` on the flights held out, the model as given first, the
    diagnosed one second; `rejected`, a line for each flight that could not be used. Where none can be used there is no
    answer, and the JSON says why. text: the answer for people. model: as diagnosed; as given where nothing was.
    """
    case = read_cases(cases).get(name)
    parent = Path(config) / case.model
    given, content = read_model(parent)
    result: dict[str, Any] = {"case": name, "answer": None, "seconds": None, "held_out": None}
    used, result["rejected"] = admit(case.fit, flights, given.vehicle, lambda flight: observe(given, [flight]))
    after, said = given, "\n".join(result["rejected"])
    began = time.process_time()
    try:
        if not used:
            raise InputError("none of the flights can be used")
        found = diagnose(given, used, seed=seed)
        result["seconds"] = time.process_time() - began
        result["answer"] = summary.as_dict(found)
        said += summary.as_text(found, verbose=True)
        after = found.model
        save_diagnosed(found, Path(model), parent=parent, content=content, flights=used)
    except InputError as error:
        result["rejected"].append(_by_name(error, case.fit, flights))
        said += f"\n{error}\n"
        save_model(given, model, standard_errors=[e.standard_errors for e in content.effects])
    result["held_out"], left_out = tested(case, flights, given, after)
    result["rejected"] += left_out
    write_json(result, Path(numbers))
    write_text(said, text)


def admit(
    windows: Sequence[Window], flights: str | Path, vehicle: Vehicle, use: Callable[[Flight], object]
) -> tuple[list[Flight], list[str]]:
    """The windows' flights that `check` lets through and `use` can work with, and a line for each other one.

    use: raises InputError where it cannot. What `check` finds dead is empty in the flights.
    """
    read = [read_flight(flight_path(flights, w)) for w in windows]
    good, lines = [], []
    for window, flight, check in zip(windows, read, checked(read, vehicle), strict=True):
        try:
            clean = admitted(flight, check)
            use(clean)
            good.append(clean)
        except InputError as error:
            lines.append(_by_name(error, [window], flights))
    return good, lines


def tested(case: RealCase, flights: str | Path, before: Model, after: Model) -> tuple[dict[str, Any] | None, list[str]]:
    """The JSON of `compare`, before first, on the flights held out (None without any); a line for each left out."""

    def use(flight: Flight) -> None:
        equation_error(before, flight, force_from=case.force_from)

    used, lines = admit(case.held, flights, before.vehicle, use) if case.held else ([], [])
    if not used:
        return None, lines
    return compared_as_dict(compare({"before": before, "after": after}, used, force_from=case.force_from)), lines


def _by_name(error: InputError, windows: Sequence[Window], flights: str | Path) -> str:
    # The line is published: where the flights lay on one machine says nothing to others.
    line = str(error)
    for window in windows:
        line = line.replace(str(flight_path(flights, window)), window.name)
    return line
