"""Which kind of log a path is, by its first bytes; and opening it."""

from __future__ import annotations

from pathlib import Path

from infotraj.errors import InputError, problem
from infotraj.flight import flight_files
from infotraj.importing.blackbox import BlackboxLog, split_number
from infotraj.importing.blackbox_header import MAGIC as BLACKBOX
from infotraj.importing.crazyflie import MAGIC, CrazyflieLog
from infotraj.importing.dataflash import DataFlashLog
from infotraj.importing.foreign import foreign
from infotraj.importing.log import Log
from infotraj.importing.rosbag import RosBag
from infotraj.importing.table import TableFile
from infotraj.importing.table_format import TableFormat
from infotraj.importing.ulog import ULogFile

_KINDS = (
    "a bag (.bag, .mcap, .db3 or a bag's folder), a ULog (.ulg), a Crazyflie micro-SD log, "
    "a blackbox (.bbl) or DataFlash (.bin) log, CSV or Parquet"
)
_TEXT_SUFFIXES = {".csv", ".tsv", ".txt", ".dat", ".log", ""}
_BINARY_SUFFIXES = {".bag": "rosbag", ".mcap": "rosbag", ".db3": "rosbag", ".ulg": "ulog", ".parquet": "table"}
_SAID = {
    "rosbag": "a ROS bag (ROS 1, MCAP or sqlite, as the name says)",
    "ulog": "a ULog",
    "crazyflie": "a Crazyflie micro-SD log",
    "blackbox": "a blackbox log of Betaflight, Cleanflight or INAV",
    "dataflash": "an ArduPilot DataFlash log",
    "table": "a table (CSV or Parquet, as the name says)",
}


def kind_of(path: Path) -> str:
    """'rosbag', 'ulog', .. (`mapping.Kind`). InputError where it is none, or not what its name says."""
    if path.is_dir():
        bag_folder(path)
        return "rosbag"
    path, number = split_number(path)
    if not path.is_file():
        raise InputError(problem(f"{path}: no such file", _KINDS, "Check the path."))
    try:
        with open(path, "rb") as file:
            head = file.read(512)
    except OSError as error:
        raise InputError(problem(f"{path}: {error.strerror}", "a readable file", "Check its permissions.")) from error
    if not head:
        raise InputError(problem(f"{path}: 0 bytes", _KINDS, "The log was never written, or not copied."))
    found = _by_content(head, path)
    named = _BINARY_SUFFIXES.get(path.suffix.lower())
    if found is None or (named is not None and found != named):
        what = _SAID.get(found or "", "text" if _is_text(head) else "bytes of no known format")
        remedy = "Rename it by what it holds." if found else "Check how it was made, and copied."
        if found is None and named is None and not _is_text(head):
            what, remedy = foreign(head, path) or (what, remedy)
        raise InputError(problem(f"{path}: holds {what}", _SAID[named] if named else _KINDS, remedy))
    if number is not None and found != "blackbox":
        raise InputError(problem(f"{path}#{number}: {_SAID[found]} holds one log", str(path), "Leave the number out."))
    return found


def open_log(
    path: Path,
    kind: str,
    ulog_topics: frozenset[str] = frozenset(),
    definitions: tuple[Path, ...] = (),
    allow_damaged: bool = False,
    layout: TableFormat | None = None,
) -> Log:
    """An open log of the given kind; the caller closes it. InputError where its bytes cannot be read."""
    if kind == "rosbag":
        return RosBag(bag_folder(path) if path.is_dir() else path, definitions)
    if kind == "ulog":
        return ULogFile(path, ulog_topics, allow_damaged)
    if kind == "crazyflie":
        return CrazyflieLog(path, allow_damaged)
    if kind == "blackbox":
        return BlackboxLog(path, allow_damaged)
    if kind == "dataflash":
        return DataFlashLog(path, allow_damaged)
    return TableFile(path, allow_damaged, layout)


def bag_folder(path: Path) -> Path:
    """The bag in a folder: the folder itself where it has its metadata.yaml, else its only .mcap or .db3."""
    if (path / "metadata.yaml").is_file():
        return path
    inside = sorted([*path.glob("*.mcap"), *path.glob("*.db3")])
    if len(inside) != 1:
        what = f"a directory with {len(inside)} bag files and no metadata.yaml" if inside else "a directory, no bag"
        raise InputError(problem(f"{path}: {what}", "metadata.yaml, or one .mcap or .db3", "Name the file itself."))
    return inside[0]


def log_files(path: Path) -> list[Path]:
    """The files that are read of a log, there or not: those of a bag's folder, and of a table also its metadata."""
    if path.is_dir():
        return [path / "metadata.yaml", *path.glob("*.mcap"), *path.glob("*.db3")]
    return flight_files(split_number(path)[0])


def kind_by_first_bytes(head: bytes) -> str | None:
    """The kind of a log that its first bytes (some tens) tell whatever it is called, 'ulog', 'crazyflie', ..; None
    where its name has to tell, or it is none. One that begins so may still be damaged."""
    if head.startswith(b"ULog\x01\x12\x35"):
        return "ulog"
    if head.startswith(BLACKBOX):
        return "blackbox"
    # The first line of a DataFlash log as text describes the lines that describe the others.
    if head.startswith((b"\xa3\x95", b"FMT, 128, 89, FMT")):
        return "dataflash"
    return "crazyflie" if head[:1] == bytes([MAGIC]) else None


def _by_content(head: bytes, path: Path) -> str | None:
    if head.startswith(b"#ROSBAG V") and path.suffix.lower() == ".bag":
        return "rosbag"
    if head.startswith(b"\x89MCAP0\r\n") and path.suffix.lower() == ".mcap":
        return "rosbag"
    if head.startswith(b"SQLite format 3\x00") and path.suffix.lower() == ".db3":
        return "rosbag"
    if head.startswith(b"PAR1") and path.suffix.lower() == ".parquet":
        return "table"
    found = kind_by_first_bytes(head)
    if found is not None:
        return found
    if _is_text(head) and path.suffix.lower() in _TEXT_SUFFIXES:
        return "table"
    return None


def _is_text(head: bytes) -> bool:
    try:
        text = head.decode("utf-8")
    except UnicodeDecodeError as error:
        # The last character may have been cut in half by reading 512 bytes.
        if error.start < len(head) - 4:
            return False
        text = head[: error.start].decode("utf-8")
    return all(c.isprintable() or c in "\t\r\n\ufeff" for c in text)
