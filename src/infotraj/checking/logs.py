"""Many logs in one go: each checked by itself, and copies among them found."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from infotraj.checking.acceptance import accepting
from infotraj.checking.admission import beside
from infotraj.checking.finding import Finding
from infotraj.checking.identical import content_hash, copy_finding
from infotraj.checking.load import load
from infotraj.checking.standing import standing
from infotraj.checking.whole import Check, examine
from infotraj.errors import InputError
from infotraj.flight import sha256
from infotraj.importing import Mapping, Settings, load_mapping
from infotraj.vehicle import Vehicle


def check_logs(
    paths: Sequence[str | Path],
    mapping: Mapping | str | Path | None = None,
    vehicle: Vehicle | None = None,
    start: float | None = None,
    stop: float | None = None,
    *,
    settings: Settings | None = None,
    accept: Collection[str] = (),
) -> Iterator[Check]:
    """The checks of logs or flight tables, in order.

    A log that cannot be read is rejected with the reason. A copy of an earlier log is rejected too: the same bytes
    without a second look, the same numbers in another format after it. accept: codes of findings that the user
    overrules, beside those that a flight's metadata accept.
    """
    chosen = load_mapping(mapping) if isinstance(mapping, (str, Path)) else mapping
    bytes_seen: dict[str, str] = {}
    numbers_seen: dict[str, str] = {}
    for path in map(Path, paths):
        digest = sha256(path) if path.is_file() else str(path.resolve())
        if digest in bytes_seen and "copy" not in accept:
            yield _refused(path, copy_finding(bytes_seen[digest], same_bytes=True))
            continue
        bytes_seen.setdefault(digest, str(path))
        try:
            loaded = load(path, chosen, start, stop, settings)
            loaded = replace(loaded, flight=accepting(loaded.flight, accept))
        except InputError as error:
            yield _refused(path, _unreadable(error))
            continue
        check = examine(loaded, vehicle)
        check = replace(check, source=str(path), findings=standing(check.findings, loaded.plan))
        numbers = content_hash(loaded.flight)
        if numbers in numbers_seen:
            check = beside(check, [copy_finding(numbers_seen[numbers], same_bytes=False)], loaded.flight)
        numbers_seen.setdefault(numbers, str(path))
        yield check


def _refused(path: Path, finding: Finding) -> Check:
    return Check(str(path), 0, 0.0, 0.0, 0.0, 0.0, "not looked at", [finding], [])


def _unreadable(error: InputError) -> Finding:
    return Finding(
        "unreadable",
        "reject",
        " ".join(str(error).split()),
        "nothing can be said about it",
        "see `infotraj import --explain`",
    )
