"""A running app, and requests to it as a browser or a stranger would send them."""

import http.client
import json
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest

QUAD = Path(__file__).parents[2] / "examples/quad"


class Server:
    """A running app of one folder."""

    def __init__(self, folder, *words):
        code = [sys.executable, "-m", "infotraj.cli", "app", str(folder), "--port", "0", "--no-browser", "-q", *words]
        self.folder = folder
        self.process = subprocess.Popen(code, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None  # a pipe
        self.address = self.process.stdout.readline().strip()
        self.port = urlsplit(self.address).port
        self.origin = f"http://127.0.0.1:{self.port}"
        self.viewer = None  # port of the recording that it serves

    def ask(self, method, path, body=None, **headers):
        """Status, headers and body of one request; headers as they are given, `Host` and `Origin` too."""
        wire = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        sent = {"Host": f"127.0.0.1:{self.port}"} | ({"Origin": self.origin} if method == "POST" else {}) | headers
        wire.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in sent.items():
            if value is not None:
                wire.putheader(name, value)
        if body is not None:
            wire.putheader("Content-Length", str(len(body)))
        try:
            wire.endheaders(body)
            answer = wire.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        except ConnectionError:  # hung up while it was sent: too large
            return 413, {}, b""
        finally:
            wire.close()

    def window(self):
        """The path of a new window."""
        status, headers, _ = self.ask("GET", "/")
        assert status == 302
        return headers["Location"].rstrip("/")

    def state(self, window):
        return json.loads(self.ask("GET", f"{window}/state")[2])

    def act(self, window, what, **body):
        status, _, said = self.ask("POST", f"{window}/{what}", json.dumps(body).encode())
        return status, json.loads(said)

    def finished(self, window, seconds=120):
        """The state when the window's job has ended."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            state = self.state(window)
            if state["job"] and state["job"]["state"] != "running":
                return state
            time.sleep(0.1)
        raise AssertionError(state["job"])

    def close(self):
        self.process.send_signal(signal.SIGTERM)
        said = self.process.communicate(timeout=20)[1]
        assert "Traceback" not in said, said
        if self.viewer is not None:  # what it started has ended with it
            with pytest.raises(ConnectionRefusedError):
                socket.create_connection(("127.0.0.1", self.viewer), timeout=5)


def filled(folder):
    """Copies the example flights and their vehicle file into a folder."""
    for k in range(3):
        shutil.copy(QUAD / f"flight_{k}.parquet", folder)
    shutil.copy(QUAD / "vehicle.yaml", folder)
