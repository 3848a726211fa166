"""Rerun's own web viewer for one recording, handed on with a policy under which it asks no other machine."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

from infotraj.errors import InfotrajError, problem

PARTS = ("", "favicon.ico", "apple-touch-icon.png", "re_viewer.js", "re_viewer_bg.wasm")


class Viewer:
    """A running viewer of one recording. source: where its parts are; address: of the page, below the window's own;
    policy: what that page may load, its parts and the recording alone."""

    def __init__(self, recording: Path) -> None:
        rerun = shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")
        if rerun is None:
            raise InfotrajError(problem("no rerun viewer", "the package rerun-sdk", "Install it."))
        page, data = _free_ports(2)
        words = [rerun, "--serve-web", "--bind", "127.0.0.1", "--web-viewer-port", str(page), "--port", str(data)]
        self._process = subprocess.Popen(
            [*words, str(recording)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.source = f"http://127.0.0.1:{page}/"
        self.address = f"viewer/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{data}%2Fproxy&renderer=webgl"
        self.policy = (
            "default-src 'none'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; "
            f"connect-src 'self' http://127.0.0.1:{data}; img-src 'self' data: blob:; worker-src blob:; "
            "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )

    @property
    def running(self) -> bool:
        """Whether it still serves."""
        return self._process.poll() is None

    def close(self) -> None:
        """Ends it with what it started: killing the wrapper alone leaves the viewer behind."""
        if self.running:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()


def _free_ports(count: int) -> list[int]:
    taken = [socket.socket() for _ in range(count)]
    for one in taken:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in taken]
    for one in taken:
        one.close()
    return ports
