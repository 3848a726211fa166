"""`infotraj data`: fetched from a server, checked by hash, accepted in either form, refused in one line."""

from __future__ import annotations

import functools
import hashlib
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from infotraj.datasets import fetch
from infotraj.datasets.command import data_command
from infotraj.errors import InfotrajError, UsageError


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *arguments: Any) -> None:
        return


@pytest.fixture
def server(tmp_path: Path) -> Iterator[tuple[str, Path]]:
    folder = tmp_path / "served"
    (folder / "logs").mkdir(parents=True)
    handler = functools.partial(_Quiet, directory=str(folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as running:
        threading.Thread(target=running.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{running.server_address[1]}", folder
        running.shutdown()


@pytest.fixture
def two_files(server: tuple[str, Path], monkeypatch: pytest.MonkeyPatch) -> tuple[str, Path]:
    found = []
    for name, data in (("a", b"first log"), ("b", b"second log")):
        (server[1] / "logs" / name).write_bytes(data)
        hashes = {name: hashlib.sha256(data).hexdigest(), f"{name}.parquet": hashlib.sha256(b"other form").hexdigest()}
        found.append(fetch.Entry(name, f"logs/{name}", hashes))
    monkeypatch.setattr(fetch, "entries", lambda name: found)
    return server


def test_fetches_what_is_missing_and_keeps_either_form(two_files: tuple[str, Path], tmp_path: Path) -> None:
    address, _ = two_files
    root = tmp_path / "data"
    (root / "nanobench").mkdir(parents=True)
    (root / "nanobench" / "b.parquet").write_bytes(b"other form")
    folder, count = fetch.fetch("nanobench", root, address)
    assert count == 1
    assert (folder / "a").read_bytes() == b"first log"
    assert not (folder / "b").exists()
    assert fetch.fetch("nanobench", root, address)[1] == 0


def test_wrong_bytes_are_refused_and_not_kept(two_files: tuple[str, Path], tmp_path: Path) -> None:
    address, served = two_files
    (served / "logs" / "b").write_bytes(b"tampered")
    with pytest.raises(InfotrajError, match=r"b: .*could not be fetched") as caught:
        fetch.fetch("nanobench", tmp_path / "data", address)
    assert len(str(caught.value).splitlines()) == 1
    assert sorted(p.name for p in (tmp_path / "data/nanobench").iterdir()) == ["a"]


def test_no_server_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InfotrajError, match="could not be fetched") as caught:
        fetch.fetch("arpl_crazyflie", tmp_path, "http://127.0.0.1:9")
    assert caught.value.exit_status == 1


def test_a_folder_that_cannot_be_written_is_told_as_such_and_nothing_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("")
    with pytest.raises(InfotrajError, match=r"data.* is a file; .*Choose another place") as caught:
        fetch.fetch("arpl_crazyflie", tmp_path / "data", "http://127.0.0.1:9")
    assert "network" not in str(caught.value)


def test_manifests_name_every_file() -> None:
    assert (len(fetch.entries("nanobench")), len(fetch.entries("arpl_crazyflie"))) == (26, 3)
    for name in fetch.DATA_SETS:
        for entry in fetch.entries(name):
            assert all(len(digest) == 64 for digest in entry.hashes.values())
    with pytest.raises(UsageError):
        fetch.entries("moon_landing")


def test_list_says_what_is_here(tmp_path: Path) -> None:
    result = CliRunner().invoke(data_command, ["list", "--dir", str(tmp_path), "--json", str(tmp_path / "list.json")])
    assert result.exit_code == 0
    assert f"0 of 26 files in {tmp_path}/nanobench" in result.stdout
    assert (tmp_path / "list.json").is_file()


def test_real_files_are_recognised() -> None:
    from infotraj.datasets.location import find_dataset, how_to_get

    for name in fetch.DATA_SETS:
        folder = find_dataset(name)
        if folder is None:
            pytest.skip(how_to_get(name))
        assert all(fetch.present(entry, folder) is not None for entry in fetch.entries(name))


def test_a_list_that_cannot_be_written_is_said_before_it_is_made(tmp_path: Path) -> None:
    words = ["list", "--dir", str(tmp_path), "--json", str(tmp_path)]
    result = CliRunner().invoke(data_command, words)
    assert isinstance(result.exception, InfotrajError)
    assert "--json" in str(result.exception)
    assert not result.stdout
