"""`infotraj doctor`: what stands between a flight and an answer, in one line a flight."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from infotraj.errors import InfotrajError, InputError
from infotraj.options import accept_option, say_next
from infotraj.progress import progress, waiting
from infotraj.suggested import again, quoted
from infotraj.terminal import show

if TYPE_CHECKING:
    from infotraj.checking.whole import Check
    from infotraj.models import Model

_SHORT = 5.0  # s in the air: less is hardly more than the rotors' start and one turn


@click.command("doctor")
@click.argument("model", type=click.Path(path_type=Path))
@click.argument("flights", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FLIGHT...")
@accept_option
@click.option("-q", "--quiet", is_flag=True, help="Only flights with something in the way.")
def doctor_command(model: Path, flights: tuple[Path, ...], accept: tuple[str, ...], quiet: bool) -> None:
    """Say in one line for each FLIGHT (or log) what stands between it and an answer of MODEL, and what to do.

    Exit status 3 where something does.
    """
    from infotraj.checking.codes import known
    from infotraj.checking.logs import check_logs
    from infotraj.models import load_model

    read = load_model(model)
    ready = []
    with waiting("checking"):
        checks = check_logs(flights, None, read.vehicle, accept=known(accept))
    lines = [diagnosed(check, read, frozenset(known(accept))) for check in progress(checks, "preparing flight")]
    for check, (stands, line) in zip(checks, lines, strict=True):
        if not stands:
            ready.append(check.source)
        if stands or not quiet:
            show(f"{check.source}: {line}")
    if ready:
        say_next(f"infotraj diagnose {quoted(model, *ready)}{again('diagnose')}")
    if len(ready) < len(flights):
        sys.exit(InputError.exit_status)


def diagnosed(check: Check, model: Model, accept: frozenset[str] = frozenset()) -> tuple[bool, str]:
    """Whether something stands in the way of any answer, and the line that says what is in the way, or what is lost."""
    from infotraj.checking.report import in_the_way

    code, what = in_the_way(check)
    if code is not None:
        found = next(f.what for f in check.findings if f.code == code).rstrip(".")
        if code == "cannot_answer":
            found = "neither forces nor torques can be told from it with this vehicle"
        return True, f"{code}: {found}; do: {what}"
    if not check.source.endswith((".parquet", ".csv")):
        return True, f"a log, not yet a flight table; do: infotraj import {quoted(check.source)} -o flight.parquet"
    lost, doubtful = _unanswered(check, model, accept)
    if isinstance(lost, str):
        return True, lost
    said = "nothing stands in the way"
    said += "".join(f"; warning {f.code}: {f.what}" for f in check.findings if f.counts == "warning")
    if check.airborne_seconds < _SHORT:
        said += f"; only {check.airborne_seconds:.1f} s in the air: fly longer, or several times"
    if lost:
        said += "; not judged: " + ", ".join(f"{axes} ({why})" for why, axes in lost.items())
    if doubtful:
        said += f"; doubtful: {' '.join(doubtful)} (the file predicts worse than nothing: order, spins, time stamps?)"
    return False, said


def _unanswered(check: Check, model: Model, accept: frozenset[str]) -> tuple[dict[str, str] | str, list[str]]:
    """Why which axes cannot be judged, {reason: axes}, or a line where none can; and the axes that may not be."""
    from infotraj.checking.acceptance import accepting
    from infotraj.checking.admission import admitted
    from infotraj.comparing.equation_error import AXES, equation_error
    from infotraj.comparing.statistics import statistics
    from infotraj.flight import read_flight

    try:
        error = equation_error(model, admitted(accepting(read_flight(check.source), accept), check))
    except InfotrajError as refused:
        return str(refused), []
    if len(error.reasons) == len(AXES):
        return f"no axis can be judged: {'; '.join(dict.fromkeys(error.reasons.values()))}", []
    if not error.scored.any():
        left_out = ", ".join(f"{count} {why}" for why, count in error.left_out.items() if count)
        return f"no row can be used ({left_out or 'too short'}); do: fly longer, or check `airborne`", []
    lost = {why: " ".join(axis for axis in AXES if error.reasons.get(axis) == why) for why in error.reasons.values()}
    return lost, [axis for axis in statistics([error]).worse_than_none if axis.startswith("t")]
