"""Many logs in one go: each checked, those of one mapping judged alike, and copies among them found."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import replace
from pathlib import Path

from infotraj.arguments import AnyPath, is_path
from infotraj.checking.acceptance import accepting
from infotraj.checking.admission import beside
from infotraj.checking.conventions import convention_findings
from infotraj.checking.finding import Finding
from infotraj.checking.identical import content_hash, copy_finding
from infotraj.checking.load import Loaded, load
from infotraj.checking.motion import Judge
from infotraj.checking.pooled import agreed, mapping_key
from infotraj.checking.settings import by_mapping
from infotraj.checking.standing import standing
from infotraj.checking.whole import Check, examine
from infotraj.errors import InputError
from infotraj.flight import Flight, sha256
from infotraj.importing import Mapping, Settings, load_mapping
from infotraj.progress import step
from infotraj.suggested import quoted
from infotraj.vehicle import Vehicle


def check_logs(
    paths: Sequence[AnyPath],
    mapping: Mapping | AnyPath | None = None,
    vehicle: Vehicle | None = None,
    start: float | None = None,
    stop: float | None = None,
    *,
    settings: Settings | None = None,
    accept: Collection[str] = (),
) -> list[Check]:
    """The checks of logs or flight tables, in order; logs that share a mapping get one answer about conventions.

    A log that cannot be read is rejected with the reason. A copy of an earlier log is rejected too: the same bytes
    without a second look, the same numbers in another format after it. accept: codes of findings that the user
    overrules, beside those that a flight's metadata accept.
    """
    chosen = load_mapping(mapping) if is_path(mapping) else mapping

    def read(path: Path) -> Loaded:
        loaded = load(path, chosen, start, stop, settings)
        return replace(loaded, flight=accepting(loaded.flight, accept))

    def judged(path: Path, loaded: Loaded, judge: Judge = convention_findings) -> Check:
        found = examine(loaded, vehicle, judge)
        findings = standing(found.findings, loaded.plan, loaded.flight.meta)
        if is_path(mapping):
            findings = [replace(f, remedy=by_mapping(f.remedy, str(mapping))) for f in findings]
        return replace(found, source=str(path), findings=findings)

    bytes_seen: dict[str, str] = {}
    numbers_seen: dict[str, str] = {}
    checks: list[Check] = []
    keys: list[Hashable] = []
    copies: dict[int, tuple[Finding, Flight]] = {}
    for number, path in enumerate(map(Path, paths), 1):
        step(number, len(paths), path.name, alike=True)
        digest = sha256(path) if path.is_file() else str(path.resolve())
        keys.append(str(path))
        if digest in bytes_seen and "copy" not in accept:
            checks.append(_refused(path, copy_finding(bytes_seen[digest], same_bytes=True)))
            continue
        bytes_seen.setdefault(digest, str(path))
        try:
            loaded = read(path)
        except InputError as error:
            checks.append(_refused(path, _unreadable(path, error)))
            continue
        numbers = content_hash(loaded.flight)
        if numbers in numbers_seen:
            again = copy_finding(numbers_seen[numbers], same_bytes=False)
            copies[len(checks)] = again, Flight(loaded.flight.table.iloc[:2], loaded.flight.meta)
        numbers_seen.setdefault(numbers, str(path))
        keys[-1] = mapping_key(loaded.flight)
        checks.append(judged(path, loaded))
    places = [Path(p) for p in paths]
    checks = agreed(checks, keys, lambda k, judge: judged(places[k], read(places[k]), judge))
    for k, (again, flight) in copies.items():
        checks[k] = beside(checks[k], [again], flight)
    return checks


def _refused(path: Path, finding: Finding) -> Check:
    return Check(str(path), 0, 0.0, 0.0, 0.0, 0.0, "not looked at", [finding], [])


def _unreadable(path: Path, error: InputError) -> Finding:
    # Of the one line that import says: what was found and expected, and what to do.
    line = " ".join(str(error).split()).removeprefix(f"{path}: ")
    found, _, rest = line.partition("; expected ")
    expected, _, remedy = rest.partition(". ")
    what = f"{found}, expected {expected}" if remedy else line
    explain = f"infotraj import {quoted(path)} --explain"
    return Finding("unreadable", "reject", what, "nothing can be said about it", remedy.rstrip(".") or explain)
