"""One file that was dropped or chosen, looked at in a process of its own: a broken one cannot hurt the server.

`python -m infotraj.app.receiving FILE`, run in the app's folder: standard output ends with one line of JSON.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from infotraj.errors import InfotrajError, InputError, problem


def received(path: Path) -> dict[str, Any]:
    """What a file of the working directory holds and what `check` says of it; a log is imported beside itself.

    name: the flight or model that can be used, None where there is none; outcome, report: for people.
    """
    if path.suffix.lower() in (".yaml", ".yml"):
        return _model(path)
    from infotraj.checking.logs import check_logs
    from infotraj.checking.report import as_text

    is_table = _is_table(path)
    (check,) = check_logs([path])
    found = {"name": str(path), "outcome": check.outcome, "report": as_text(check, details=True)}
    if check.outcome == "rejected":
        return found | {"name": None}
    if is_table:
        return found
    target = _imported(path)
    return found | {"name": str(target), "report": f"imported as {target}\n{found['report']}"}


def _is_table(path: Path) -> bool:
    """Whether a file is a flight table as it stands."""
    from infotraj.flight import read_flight

    if path.suffix.lower() not in (".csv", ".parquet"):
        return False
    try:
        read_flight(path)
    except InputError:
        return False
    return True


def _imported(log: Path) -> Path:
    """The flight table that a log was turned into, under a name that was free."""
    from infotraj.importing import read_streams, to_flight

    flight = to_flight(read_streams(log))
    number = 0
    while True:
        number += 1
        target = log.with_name(f"{log.stem}{f'-{number}' if number > 1 else ''}.parquet")
        try:
            open(target, "x").close()  # the name is ours from here on
        except FileExistsError:
            continue
        try:
            flight.write(target)
        except BaseException:
            target.unlink()
            raise
        return target


def _model(path: Path) -> dict[str, Any]:
    from infotraj.models.content import read_content
    from infotraj.models.file import read_model

    content = read_content(path)
    if isinstance(content.vehicle, str):
        named = Path(content.vehicle)
        place = (named if named.is_absolute() else path.parent / named).resolve()
        if not place.is_relative_to(Path.cwd().resolve()):
            raise InputError(problem(f"{path}: a vehicle file outside the folder", "one inside it", "Put it there."))
    model, _ = read_model(path)
    vehicle = model.vehicle
    held = ", ".join(e.name for e in model.effects) or "no effects"
    said = f"{vehicle.name}: {len(vehicle.rotors)} rotors, {len(vehicle.tilts)} tilts; {held}"
    return {"name": str(path), "outcome": "passed", "report": said}


def main() -> None:
    """Prints what was received; a file that cannot be used is an answer, too."""
    try:
        answer = received(Path(sys.argv[1]))
    except InfotrajError as error:
        answer = {"name": None, "outcome": "rejected", "report": f"{error}"}
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
