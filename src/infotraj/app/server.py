"""The app's web server: loopback only, requests of its own page only, bodies of a limited size."""

from __future__ import annotations

import asyncio
import json
import os
import secrets
import signal
import webbrowser
from importlib.resources import files
from pathlib import Path
from typing import Any

import click
import tornado.http1connection
import tornado.httpclient
import tornado.httpserver
import tornado.netutil
import tornado.web

from infotraj.app.dropped_bag import METADATA
from infotraj.app.folder import FLIGHTS, HEAD, LOGS, MODELS, Folder, log_name, open_folder, require_log
from infotraj.app.viewer import PARTS
from infotraj.app.window import Window
from infotraj.errors import InfotrajError, UsageError, problem

ADDRESS = "127.0.0.1"
_SMALL = 1_000_000  # bytes of a request that is no log, and of a model file
_MOST_WINDOWS = 50
_TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}
_OWN = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; frame-src 'self'; img-src data:"
_OWN += "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_REPORT = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
_REPORT += "; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"


class App:
    """The folder, its windows by key, the largest upload (bytes), and the port."""

    def __init__(self, folder: Folder, upload_limit: int) -> None:
        self.folder, self.upload_limit = folder, upload_limit
        self.windows: dict[str, Window] = {}
        self.port = 0

    @property
    def hosts(self) -> tuple[str, ...]:
        """What a browser may call this server: a name that only points here (DNS rebinding) is none of it."""
        return tuple(f"{name}:{self.port}" for name in (ADDRESS, "localhost"))

    def open_window(self) -> Window:
        """A new window; the oldest idle one gives way where there are too many."""
        if len(self.windows) >= _MOST_WINDOWS:
            idle = [k for k, w in self.windows.items() if w.job is None or w.job.state != "running"]
            self.windows.pop(idle[0] if idle else next(iter(self.windows))).close()
        key = secrets.token_urlsafe(24)
        self.windows[key] = Window(key, self.folder)
        return self.windows[key]

    def close(self) -> None:
        """Ends what runs and removes what the server wrote for itself."""
        for window in self.windows.values():
            window.close()
        self.folder.close()


class Handler(tornado.web.RequestHandler):
    """What every request passes."""

    policy = _OWN

    def initialize(self, app: App) -> None:
        self.app = app

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in {
            "Content-Security-Policy": self.policy,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
            "Cross-Origin-Resource-Policy": "same-origin",
        }.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        if self.request.host not in self.app.hosts:
            raise tornado.web.HTTPError(403, "host")
        if self.request.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
            raise tornado.web.HTTPError(403, "site")
        origin = self.request.headers.get("Origin")
        own = origin in {f"http://{host}" for host in self.app.hosts}
        if (origin is not None and not own) or (self.request.method == "POST" and not own):
            raise tornado.web.HTTPError(403, "origin")

    def window(self, key: str) -> Window:
        """The window of that key; 404 where there is none."""
        found = self.app.windows.get(key)
        if found is None:
            raise tornado.web.HTTPError(404)
        return found

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        error = kwargs.get("exc_info", (None, None))[1]
        self.set_header("Content-Type", "application/json")
        said = str(error) if isinstance(error, InfotrajError) else self._reason
        self.finish(json.dumps({"error": said}))

    def log_exception(self, kind: Any, value: Any, trace: Any) -> None:
        if not isinstance(value, (tornado.web.HTTPError, InfotrajError)):
            super().log_exception(kind, value, trace)


class Front(Handler):
    """A new window."""

    def get(self) -> None:
        self.redirect(f"/w/{self.app.open_window().key}/")


class Asset(Handler):
    """The page and its parts: shipped files, by their names."""

    def get(self, key: str, name: str = "") -> None:
        self.window(key)
        name = name or "app.html"
        self.set_header("Content-Type", f"{_TYPES[Path(name).suffix]}; charset=utf-8")
        self.finish((files("infotraj.app") / "assets" / name).read_bytes())


class State(Handler):
    """What the window shows."""

    def get(self, key: str) -> None:
        told = {"upload_limit": self.app.upload_limit, "suffixes": FLIGHTS + LOGS + MODELS}
        self.finish(self.window(key).shown() | told)


class Action(Handler):
    """Something that the page asks for, as JSON."""

    def post(self, key: str, what: str) -> None:
        window = self.window(key)
        try:
            body = json.loads(self.request.body or b"{}")
            if not isinstance(body, dict):
                raise ValueError
        except ValueError:
            raise tornado.web.HTTPError(400) from None
        lists = {k: body.get(k) or [] for k in ("flights", "healthy", "effects")}
        if not all(isinstance(v, list) for v in lists.values()):
            raise tornado.web.HTTPError(400)
        if what != "check":  # files are looked at while what was written is still being read
            window.note = ""
        try:
            if what == "check":
                window.receive(body.get("name"), body.get("mapping"), body.get("model"))
            elif what == "fix":
                window.fix(body.get("name"), body.get("model"))
            elif what == "bag":
                self.finish({"name": window.bag.into(self.app.folder, str(body.get("name")))})
                return
            elif what == "diagnose":
                window.diagnose(body.get("model"), lists["flights"], lists["healthy"])
            elif what == "save":
                window.save(body.get("name"), lists["effects"])
            elif what == "design":
                window.design(body.get("box"), body.get("seconds"))
            elif what == "record":
                window.record()
            else:
                window.cancel()
        except InfotrajError as error:
            self.set_status(400)
            self.finish({"error": str(error)})
            return
        self.finish(window.shown())


@tornado.web.stream_request_body
class Upload(Handler):
    """A log or a model that was dropped, or a file of a bag: written as it comes, to a name that is ours."""

    def prepare(self) -> None:
        self.part: Path | None = None
        super().prepare()
        window = self.window(self.path_args[0])
        name = self.get_query_argument("name", "")
        self.bag = window.bag if self.get_query_argument("bag", None) is not None else None
        self.name = self.bag.named(name) if self.bag else log_name(name)
        self.limit = _SMALL if self.name.endswith(MODELS) else self.app.upload_limit
        if self.bag is not None and self.name != METADATA:
            self.limit = max(self.limit - self.bag.size, 0)
        if int(self.request.headers.get("Content-Length", "0")) > self.limit:
            raise UsageError(self._too_large())
        connection = self.request.connection
        assert isinstance(connection, tornado.http1connection.HTTP1Connection)  # what tornado serves
        connection.set_max_body_size(self.limit)
        self.part = window.work / f"{secrets.token_hex(8)}.part"
        self.file = open(self.part, "xb")  # noqa: SIM115 (closed when the request is over)
        self.count = 0
        self.begins = b""

    def data_received(self, chunk: bytes) -> None:
        self.count += len(chunk)
        if self.count > self.limit:
            raise UsageError(self._too_large())
        self.begins += chunk[: HEAD - len(self.begins)]
        self.file.write(chunk)

    def post(self, key: str) -> None:
        self.file.close()
        assert self.part is not None
        require_log(self.name, self.begins)
        if self.bag is not None:
            self.bag.take(self.part, self.name)
            self.finish({"name": self.name})
            return
        self.finish({"name": self.app.folder.take(self.part, self.name).name})

    def on_finish(self) -> None:
        self._drop()

    def on_connection_close(self) -> None:
        self._drop()

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        if isinstance(kwargs.get("exc_info", (None, None))[1], InfotrajError):
            self.set_status(400)
        super().write_error(status_code, **kwargs)

    def _too_large(self) -> str:
        return problem(f"{self.name}: too large", f"at most {self.limit / 1e6:g} MB", "Cut it, or give --upload-limit.")

    def _drop(self) -> None:
        if self.part is not None:
            self.file.close()
            self.part.unlink(missing_ok=True)


class Report(Handler):
    """The page of the last diagnosis; with ?download as a file."""

    policy = _REPORT

    def get(self, key: str) -> None:
        window = self.window(key)
        if not window.page.is_file():
            raise tornado.web.HTTPError(404)
        if self.get_query_argument("download", None) is not None:
            self.set_header("Content-Disposition", 'attachment; filename="report.html"')
        self.set_header("Content-Type", "text/html; charset=utf-8")
        # The page is kept and sent on: the window's own folder ends with the app, and its name is the window's key.
        own = f"{window.work.relative_to(window.folder.top)}{os.sep}"
        self.finish(window.page.read_text("utf-8").replace(own, ""))


class View(Handler):
    """A part of rerun's viewer, handed on with the policy of this window's recording."""

    async def get(self, key: str, name: str) -> None:
        viewer = self.window(key).viewer
        if viewer is None or not viewer.running or name not in PARTS:
            raise tornado.web.HTTPError(404)
        try:
            client = tornado.httpclient.AsyncHTTPClient()
            found = await client.fetch(viewer.source + name, request_timeout=60.0)
        except (OSError, tornado.httpclient.HTTPError) as error:
            raise tornado.web.HTTPError(404) from error
        self.set_header("Content-Security-Policy", viewer.policy)
        self.set_header("Content-Type", found.headers.get("Content-Type", "application/octet-stream"))
        if "rerun-final-length" in found.headers:
            self.set_header("rerun-final-length", found.headers["rerun-final-length"])
        self.finish(found.body)


def handlers(app: App) -> tornado.web.Application:
    """Every address that there is."""
    own = {"app": app}
    key = r"/w/([A-Za-z0-9_-]{32})"
    return tornado.web.Application(
        [
            (r"/", Front, own),
            (key + r"/(app\.css|app\.js)?", Asset, own),
            (key + r"/state", State, own),
            (key + r"/report", Report, own),
            (key + r"/upload", Upload, own),
            (key + r"/viewer/([A-Za-z0-9_.-]*)", View, own),
            (key + r"/(check|fix|bag|diagnose|save|design|record|cancel)", Action, own),
        ],
        default_handler_class=_Nothing,
        default_handler_args=own,
        log_function=lambda handler: None,
        autoreload=False,
        debug=False,
    )


class _Nothing(Handler):
    def prepare(self) -> None:
        super().prepare()
        raise tornado.web.HTTPError(404)


def serve(path: Path, *, port: int, upload_limit: int, browser: bool, quiet: bool) -> None:
    """Serves a folder until it is interrupted. InputError for a folder, UsageError for a port that cannot be used."""
    try:
        sockets = tornado.netutil.bind_sockets(port, ADDRESS)
    except OSError as error:
        raise UsageError(problem(f"port {port}: {error.strerror}", "a free port", "Give --port 0.")) from error
    folder = open_folder(path)
    app = App(folder, upload_limit)
    app.port = sockets[0].getsockname()[1]

    async def run() -> None:
        stop = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, stop.set)
        server = tornado.httpserver.HTTPServer(handlers(app), max_body_size=_SMALL)
        server.add_sockets(sockets)
        click.echo(f"http://{ADDRESS}:{app.port}/")
        if not quiet:
            click.echo(f"serving {folder.top}; Ctrl-C ends it", err=True)
        if browser:
            webbrowser.open(f"http://{ADDRESS}:{app.port}/")
        await stop.wait()

    try:
        asyncio.run(run())
    finally:
        app.close()
