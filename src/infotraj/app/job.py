"""One command in a process of its own: its lines are followed, and it can be stopped with all that it started."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

_LINES, _LONGEST = 200, 2000  # lines that are kept, characters of each
_GRACE = 3.0  # s to end by itself


class Job:
    """A Python process `python WORDS` in `folder`. `kind`: what it is for; done: called once with the finished job."""

    def __init__(
        self, kind: str, words: Sequence[str], folder: Path, done: Callable[[Job], None] | None = None
    ) -> None:
        self.kind, self.words, self.folder = kind, list(words), folder
        self.done = done or (lambda job: None)
        self.state = "running"  # then done, failed or cancelled
        self.said: list[str] = []
        self.printed: list[str] = []
        self.begun = time.monotonic()
        self.ended: float | None = None
        self.process: asyncio.subprocess.Process | None = None
        self.task: asyncio.Task[None] | None = None

    def start(self, environment: Mapping[str, str]) -> Job:
        """Starts it in the running event loop."""
        self.task = asyncio.get_running_loop().create_task(self._run({**os.environ, **environment}))
        return self

    def cancel(self) -> None:
        """Ends it, and what it started, soon."""
        if self.state != "running":
            return
        self.state = "cancelled"
        self._signal(signal.SIGTERM)
        asyncio.get_running_loop().call_later(_GRACE, self._signal, signal.SIGKILL)

    def kill(self) -> None:
        """Ends it at once."""
        self.state = "cancelled" if self.state == "running" else self.state
        self._signal(signal.SIGKILL)

    def shown(self) -> dict[str, Any]:
        """For the page."""
        # One that is cancelled goes on for a moment.
        until = time.monotonic() if self.ended is None else self.ended
        return {"kind": self.kind, "state": self.state, "said": self.said[-20:], "seconds": until - self.begun}

    async def _run(self, environment: Mapping[str, str]) -> None:
        pipe = asyncio.subprocess.PIPE
        try:
            self.process = await asyncio.create_subprocess_exec(
                sys.executable, *self.words, cwd=self.folder, env=dict(environment), stdin=asyncio.subprocess.DEVNULL,
                stdout=pipe, stderr=pipe, start_new_session=True, limit=1 << 20,
            )  # fmt: skip
            if self.state == "cancelled":
                self._signal(signal.SIGKILL)
            assert self.process.stdout is not None
            assert self.process.stderr is not None
            await asyncio.gather(
                _follow(self.process.stdout, self.printed), _follow(self.process.stderr, self.said), self.process.wait()
            )
            if self.state == "running":
                self.state = "done" if self.process.returncode == 0 else "failed"
        except Exception as error:  # whatever a command does, the server goes on
            self.said.append(f"error: {error}")
            self.state = "failed"
            self._signal(signal.SIGKILL)
        finally:
            self.ended = time.monotonic()
            self.done(self)

    def _signal(self, number: int) -> None:
        if self.process is not None and self.process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, number)


async def _follow(stream: asyncio.StreamReader, lines: list[str]) -> None:
    while True:
        try:
            line = await stream.readline()
        except ValueError:  # longer than the limit: what was read of it is dropped
            continue
        if not line:
            return
        lines.append(line.decode("utf-8", "replace").rstrip()[: _LONGEST * 100])
        del lines[:-_LINES]
