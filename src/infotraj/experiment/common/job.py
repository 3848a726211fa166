"""What every job of the workflow does around its one call: the log, the threads, the settings that it may read."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

from threadpoolctl import threadpool_limits

from infotraj.errors import InfotrajError
from infotraj.experiment.common.config import ExperimentConfig, load


class Settings:
    """The part of the configuration that a job declares. Reading any other key is an error.

    A key that a stage reads without declaring it would not rerun the stage when it changes.
    """

    def __init__(self, declared: Mapping[str, Any]) -> None:
        self._config = load(declared)
        self._names = frozenset(declared)

    def __getattr__(self, name: str) -> Any:
        if name in self._names:
            return getattr(self._config, name)
        raise AttributeError(f"setting '{name}' is not declared; add it to the rule's `settings`")


@contextmanager
def job(log: str | Path, declared: Mapping[str, Any] | None = None) -> Iterator[ExperimentConfig]:
    """Sends all output of this process to the file `log` and gives the declared settings, in the configuration's place.

    A user's error ends the process with its exit status and one line in the log; any other keeps its traceback. Linear
    algebra runs on one thread: the matrices are small, and jobs share the cores.
    """
    Path(log).parent.mkdir(parents=True, exist_ok=True)
    with open(log, "w") as file:
        sys.stdout.flush()
        sys.stderr.flush()
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    try:
        with threadpool_limits(1, user_api="blas"):
            yield cast(ExperimentConfig, Settings(declared or {}))
    except InfotrajError as error:
        print(error, file=sys.stderr)
        raise SystemExit(error.exit_status) from error
