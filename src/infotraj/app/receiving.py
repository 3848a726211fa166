"""One file that was dropped or chosen, looked at in a process of its own: a broken one cannot hurt the server.

`python -m infotraj.app.receiving FILE [--mapping NAME] [--model FILE] [--fix]`, run in the app's folder: the last line
that it prints is JSON.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import yaml

from infotraj.app.folder import is_mapping
from infotraj.errors import InfotrajError, InputError, UsageError, problem
from infotraj.vehicle import Vehicle

_DEEPEST = 8  # mappings that extend one another


def received(path: Path, mapping: str | None = None, model: Path | None = None) -> dict[str, Any]:
    """What a file of the working directory holds and what `check` says of it; a log is imported beside itself.

    mapping: a shipped one by its name, or a file of the working directory; None: the one that is recognised. model: of
    the vehicle that flew; None, or one that cannot be read: any vehicle.
    Gives name: the flight or model that can be used, None where there is none; outcome, report: for people; fix: what
    the findings say to set, empty where no setting would mend them; mapping, as given; kind, mappings: of a log that
    was not usable by the mapping that it was read with, and the shipped ones that read this kind; model: the one that
    the log was held against, or None; reads: of a mapping, the kinds of log that it reads.
    """
    if path.suffix.lower() in (".yaml", ".yml"):
        return _mapping(path) if is_mapping(path) else _model(path)
    from infotraj.checking.logs import check_logs
    from infotraj.checking.report import as_text

    _require_inside(mapping)
    is_table = mapping is None and _is_table(path)
    vehicle = _vehicle(model)
    try:
        (check,) = check_logs([path], mapping, vehicle)
    except UsageError as error:  # of the mapping; another may do
        return _refused(error) | _readers(path)
    found: dict[str, Any] = {
        "name": str(path),
        "outcome": check.outcome,
        "report": as_text(check, details=True),
        "mapping": mapping,
    }
    found["model"] = str(model) if vehicle is not None else None
    found["fix"] = [s for f in check.findings if f.counts != "note" for s in f.settings]
    if check.outcome == "rejected":
        return found | {"name": None} | ({} if is_table else _readers(path))
    if is_table:
        return found
    target = _imported(path, mapping)
    return found | {"name": str(target), "report": f"imported as {target}\n{found['report']}"}


def mended(path: Path, mapping: str | None = None, model: Path | None = None) -> dict[str, Any]:
    """The same of a log once `import --fix` has mended it: written to a new table beside it, and that one checked.

    name is None, and nothing is written, where no setting makes it usable.
    """
    from infotraj.checking.logs import check_logs
    from infotraj.checking.mending import mend
    from infotraj.checking.report import as_text
    from infotraj.importing import load_mapping, read_streams, to_flight
    from infotraj.importing.saving import save_extension

    _require_inside(mapping)
    chosen = load_mapping(mapping) if mapping is not None else None
    fix = mend(path, chosen)
    lines = [f"set {setting} ({code}: {what})" for setting, code, what in fix.changed]
    if any(finding.severity == "reject" for finding in fix.left) or not lines:
        lines += [f"left: {finding.code}: {finding.what}" for finding in fix.left]
        return {"name": None, "outcome": "rejected", "report": "\n".join(["no setting makes it usable", *lines])}
    flight = to_flight(read_streams(path, chosen, settings=fix.settings))
    target, saved = _claimed(path, "-fixed", ".parquet", ".mapping.yaml")
    try:
        flight.write(target)
        save_extension(mapping or flight.meta["mapping"], fix.settings, saved)
        vehicle = _vehicle(model)
        (check,) = check_logs([target], vehicle=vehicle)
    except BaseException:
        target.unlink()
        saved.unlink()
        raise
    report = "\n".join([f"{path} with these settings, which {saved} holds:", *lines, as_text(check, details=True)])
    if check.outcome == "rejected":
        target.unlink()
        saved.unlink()
        return {"name": None, "outcome": "rejected", "report": f"still rejected, so it is not kept\n{report}"}
    against = str(model) if vehicle is not None else None
    return {"name": str(target), "outcome": check.outcome, "report": report, "model": against}


def _is_table(path: Path) -> bool:
    """Whether a file is a flight table as it stands."""
    from infotraj.flight import read_flight

    if path.suffix.lower() not in (".csv", ".parquet") or not path.is_file():
        return False
    try:
        read_flight(path)
    except InputError:
        return False
    return True


def _imported(log: Path, mapping: str | None) -> Path:
    """The flight table that a log was turned into, under a name that was free."""
    from infotraj.importing import read_streams, to_flight

    flight = to_flight(read_streams(log, mapping))
    (target,) = _claimed(log, "", ".parquet")
    try:
        flight.write(target)
    except BaseException:
        target.unlink()
        raise
    return target


def _claimed(log: Path, ending: str, *suffixes: str) -> list[Path]:
    """New empty files beside a log, named after it, one a suffix: nothing is overwritten."""
    stem = log.name if log.is_dir() else log.stem
    number = 0
    while True:
        number += 1
        made: list[Path] = []
        try:
            for suffix in suffixes:
                path = log.with_name(f"{stem}{ending}{f'-{number}' if number > 1 else ''}{suffix}")
                open(path, "x").close()  # the name is ours from here on
                made.append(path)
        except FileExistsError:
            for path in made:
                path.unlink()
            continue
        return made


def _readers(path: Path) -> dict[str, Any]:
    """The kind of a log, and the shipped mappings for it; nothing for what cannot be opened, which no mapping mends."""
    from infotraj.importing import shipped
    from infotraj.importing.explain import inventory
    from infotraj.importing.opening import kind_of

    try:
        kind = kind_of(path)
        inventory(path)
    except InputError:
        return {}
    return {"kind": kind, "mappings": [name for name, mapping in shipped().items() if kind in mapping.reads]}


def _require_inside(mapping: str | None) -> None:
    """UsageError for a mapping that would read files outside the working directory: its bases, its definitions."""
    from infotraj.importing import shipped

    top, name = Path.cwd().resolve(), mapping
    for _ in range(_DEEPEST):
        if name is None or name in shipped():
            return
        path = Path(name)
        try:
            content = yaml.safe_load(path.read_text()) if path.resolve().is_relative_to(top) else None
        except (OSError, yaml.YAMLError, ValueError, RecursionError):
            return  # whoever reads it says what is wrong
        content = content if isinstance(content, dict) else {}
        base, others = content.get("extends"), content.get("definitions")
        beside = path.parent / str(base)
        name = None if base is None else str(base) if base in shipped() or not beside.is_file() else str(beside)
        named = [name] if name is not None and name not in shipped() else []
        named += [str(p) for p in (others if isinstance(others, list) else [others] if others else [])]
        outside = [p for p in (str(path), *named) if not Path(p).resolve().is_relative_to(top)]
        if outside:
            raise UsageError(
                problem(f"{mapping}: {outside[0]} is outside the folder", "one inside it", "Put it there.")
            )


def _mapping(path: Path) -> dict[str, Any]:
    from infotraj.importing import load_mapping

    _require_inside(str(path))
    mapping = load_mapping(path)
    said = f"mapping {mapping.name}, for {', '.join(mapping.reads)}"
    return {"name": str(path), "outcome": "passed", "report": said, "reads": list(mapping.reads)}


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


def _vehicle(model: Path | None) -> Vehicle | None:
    """The vehicle of a model of the folder; what is wrong with a model is said in its own place."""
    try:
        if model is None:
            return None
        _model(model)  # nothing outside the folder is read
        from infotraj.models.file import read_model

        return read_model(model)[0].vehicle
    except InfotrajError:
        return None


def _refused(error: InfotrajError) -> dict[str, Any]:
    return {"name": None, "outcome": "rejected", "report": f"{error}"}


def main() -> None:
    """Prints what was received; a file that cannot be used is an answer, too."""
    words = argparse.ArgumentParser()
    words.add_argument("file", type=Path)
    words.add_argument("--mapping")
    words.add_argument("--model", type=Path)
    words.add_argument("--fix", action="store_true")
    asked = words.parse_args()
    try:
        answer = (mended if asked.fix else received)(asked.file, asked.mapping, asked.model)
    except InfotrajError as error:
        answer = _refused(error)
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
