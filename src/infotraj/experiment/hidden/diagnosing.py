"""Diagnoses runs of the hidden-effect study with the public command, given the flight tables and the vehicle alone."""

from __future__ import annotations

import json
import resource
import signal
import time
from collections.abc import Sequence
from pathlib import Path

from infotraj.diagnosis.report.command import diagnose_command
from infotraj.errors import InfotrajError

LIMIT = 120.0  # s of CPU for one diagnosis: ten times what it is meant to take


class _TooLongError(BaseException):
    """A diagnosis took more than LIMIT. No `except Exception` on the way may swallow it."""


def _too_long(signal_number: int, frame: object) -> None:
    raise _TooLongError


def diagnose_batch(*, flights: Path, answers: Path) -> None:
    """Runs `infotraj diagnose vehicle.yaml flight_*.parquet --json` in every folder flights/run_K.

    Writes answers/run_K/answer.json, model.yaml (where an effect was supported) and time.json: seconds and status.
    Nothing for a run that could not be flown.
    """
    for run in sorted(flights.glob("run_*")):
        folder = answers / run.name
        folder.mkdir(parents=True, exist_ok=True)
        tables = sorted(str(path) for path in run.glob("flight_*.parquet"))
        if not tables:
            continue
        answer(run / "vehicle.yaml", tables, folder, "--save-model", str(folder / "model.yaml"))


def answer(model: Path, tables: Sequence[str], folder: Path, *options: str, limit: float = LIMIT) -> None:
    """Runs `infotraj diagnose MODEL TABLES --json` with further options, for at most `limit` s of CPU.

    Writes folder/answer.json, where there is an answer, and folder/time.json: seconds, exit status and error.
    """
    arguments = [str(model), *tables, "-q", "--json", str(folder / "answer.json"), *options]
    status, said = 0, ""
    start, used = time.perf_counter(), _cpu()
    signal.signal(signal.SIGPROF, _too_long)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        diagnose_command.main(arguments, prog_name="infotraj diagnose", standalone_mode=False)
    except InfotrajError as error:
        status, said = error.exit_status, str(error)
    except _TooLongError:
        status, said = 1, f"given up after {limit:g} s of CPU"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    spent = {"wall": time.perf_counter() - start, "cpu": _cpu() - used, "status": status, "error": said}
    (folder / "time.json").write_text(json.dumps(spent))


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime
