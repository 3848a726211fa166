"""Fetches the public data sets from their repositories at a fixed commit, each file checked by its sha256."""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from infotraj.datasets.location import VARIABLE
from infotraj.errors import InfotrajError, UsageError, problem
from infotraj.flight import sha256
from infotraj.outputs import require_outputs
from infotraj.progress import progress


@dataclass(frozen=True)
class DataSet:
    """One public data set: where it is published, at which commit, under which licence."""

    name: str
    repository: str
    commit: str
    licence: str
    what: str

    @property
    def address(self) -> str:
        """Where the repository's files are served, without the path inside it."""
        return f"https://raw.githubusercontent.com/{self.repository}/{self.commit}"


DATA_SETS = {
    d.name: d
    for d in (
        DataSet(
            "nanobench",
            "syediu/nanobench-iros2026",
            "0ae7d689749db174dc779ab2f7c416cc12e14e2b",
            "BSD-3-Clause (c) 2026 Ullah, Baca",
            "26 flights of a Crazyflie 2.1 with motion capture (arXiv 2603.09908)",
        ),
        DataSet(
            "arpl_crazyflie",
            "arplaboratory/data-driven-system-identification",
            "2d267dd07b4262f579ee223d20b26a6dc9d17147",
            "MIT (c) 2024 Jonas Eschmann",
            "3 micro-SD logs of a Crazyflie: gyro, accelerometer, motor commands, no pose",
        ),
    )
}


@dataclass(frozen=True)
class Entry:
    """One file of a data set: its path in the repository, and the hash of every accepted form by file name."""

    flight: str
    upstream_path: str
    hashes: dict[str, str]

    @property
    def upstream_name(self) -> str:
        """The name under which the repository's form is stored."""
        return Path(self.upstream_path).name


def entries(name: str) -> list[Entry]:
    """The files of a data set, from its manifest. UsageError for an unknown name."""
    _known(name)
    manifest = files("infotraj.datasets") / "manifests" / f"{name}.tsv"
    found = []
    for row in csv.DictReader(manifest.read_text().splitlines(), delimiter="\t"):
        upstream = row["upstream_path"]
        hashes = {Path(upstream).name: row.get("upstream_sha256") or row["sha256"]}
        if row.get("parquet_sha256"):
            hashes[f"{row['flight']}.parquet"] = row["parquet_sha256"]
        found.append(Entry(row["flight"], upstream, hashes))
    return found


def present(entry: Entry, folder: Path) -> Path | None:
    """The file in `folder` that holds the entry in one of its accepted forms; None where there is none."""
    for file_name, digest in entry.hashes.items():
        path = folder / file_name
        if path.is_file() and sha256(path) == digest:
            return path
    return None


def default_root() -> Path:
    """Where data sets go: the folder that INFOTRAJ_DATA names, else ./data."""
    return Path(os.environ.get(VARIABLE) or "data").expanduser()


def fetch(name: str, root: Path, address: str | None = None) -> tuple[Path, int]:
    """Fetches what is missing of a data set into root/name; (folder, files fetched).

    A file is stored only when its sha256 is right, and one that is there in an accepted form is not fetched again.
    InfotrajError, one line, where the folder cannot be written, or the network or the repository fails. `address`:
    another server of the same files.
    """
    from urllib.parse import quote

    import pooch
    import requests

    data_set = _known(name)
    folder = root / name
    quiet = pooch.get_logger()
    quiet.setLevel("ERROR")
    missing = [entry for entry in entries(name) if present(entry, folder) is None]
    if missing:
        require_outputs({}, {"--dir": folder}, {})
    for entry in progress(missing, f"fetching {name}, file"):
        url = f"{address or data_set.address}/{quote(entry.upstream_path)}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            pooch.retrieve(
                url,
                known_hash=f"sha256:{entry.hashes[entry.upstream_name]}",
                fname=entry.upstream_name,
                path=folder,
                downloader=pooch.HTTPDownloader(timeout=30),
            )
        except (OSError, ValueError, requests.RequestException) as error:
            reason = " ".join(str(error).split())[:160]
            raise InfotrajError(
                problem(
                    f"{entry.flight}: {url} could not be fetched ({reason})",
                    f"the file with sha256 {entry.hashes[entry.upstream_name][:12]}..",
                    f"Try again with a network, or put the file into {folder}.",
                )
            ) from error
    return folder, len(missing)


def _known(name: str) -> DataSet:
    if name not in DATA_SETS:
        raise UsageError(problem(f"data set {name!r} is unknown", f"one of {', '.join(DATA_SETS)}", "Correct it."))
    return DATA_SETS[name]
