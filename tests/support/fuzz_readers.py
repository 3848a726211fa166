"""Fuzzes every reader: damaged logs must end in one line of InfotrajError, or in a flight, and leave no file behind.

    python tests/support/fuzz_readers.py --minutes 60 --seed 1

Logs that the tests write, and real ones where INFOTRAJ_DATA has them, are damaged (bits, bytes, blocks, numbers in
headers, truncation, two logs in one) and imported in process, some through the command line and through `check`. Work
is done in children of 100 cases, so that a crash of compiled code is seen as one. A case is its seed: `--case N`
repeats it.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

import numpy as np

CASES = 100
SECONDS = 90  # that one case may take
LONGEST_LINE = 2000
_NUMBERS = [b"0", b"-1", b"1", b"255", b"65536", b"4294967296", b"99999999999999999999", b"nan", b"1e400", b"x", b""]


def seeds(folder: Path) -> list[Path]:
    """Whole logs of every kind, written into `folder`; with real ones, cut to 60 kB."""
    import writers_bag
    import writers_table
    from flights_made import made_flight
    from test_import_bytes import bag1_bytes, crazyflie_v1_bytes, mcap_bytes
    from writers_blackbox import blackbox_bytes
    from writers_dataflash import dataflash_bytes, dataflash_text
    from writers_ulog import ulog_bytes

    from infotraj.flight import Flight

    flight = made_flight(1.5)
    names = [c for c in flight.table if c.startswith("cmd_rotor_")]
    throttled = Flight(flight.table.assign(**{c: flight.table[c] / 1000.0 for c in names}), {})
    poses = [(7_000_000_000 + round(t * 1e9), list(map(float, row))) for t, row in zip(
        flight.t, flight.get("px", "py", "pz", "qx", "qy", "qz", "qw"), strict=True)]  # fmt: skip
    flight.write(folder / "table.parquet")
    flight.write(folder / "table.csv")
    writers_table.write_ned_csv(flight, folder / "ned.csv")
    writers_bag.write_bag1(flight, folder / "one.bag")
    writers_bag.write_bag2(flight, folder / "two_mcap", "mcap")
    writers_bag.write_bag2(flight, folder / "two_sqlite", "sqlite3")
    events = ((0.2, 136, 10), (0.3, 136, 28), (0.4, 137, 1), (1.2, 136, 18))
    content = {
        "hand.bag": bag1_bytes(poses[:40]),
        "hand.mcap": mcap_bytes(poses[:40], "uint64 micros\nfloat32[3] xyz\nfloat32[4] xyzw"),
        "log07": crazyflie_v1_bytes(
            [(1000 + 2 * k, [1.0 * k, -5.0, 0.5]) for k in range(200)], [(1000, 4.0), (1100, 3.9)]
        ),
        "px4.ulg": ulog_bytes(throttled),
        "copter.bin": dataflash_bytes(throttled, events=events),
        "copter.log": dataflash_text(throttled, events=events),
        "quad.bbl": blackbox_bytes(throttled),
        "two.bbl": blackbox_bytes(throttled) + blackbox_bytes(throttled),
    }
    for name, data in content.items():
        (folder / name).write_bytes(data)
    root = Path(os.environ.get("INFOTRAJ_DATA", "/nonexistent"))
    for real, size in (
        ("blackbox/expected/tests/logs/error-recovery.bbl", None),
        ("blackbox/src/test-data/LOG00037.BFL", 60_000),
        ("blackbox/src/test-data/btfl_all.bbl", 60_000),
        ("dataflash/tests/test.BIN", None),
        ("arpl_crazyflie/log10", 60_000),
    ):
        if (root / real).is_file():
            (folder / f"real_{Path(real).name}").write_bytes((root / real).read_bytes()[:size])
    return sorted(p for p in folder.iterdir() if not p.name.endswith(".meta.yaml"))


def damaged(source: Path, others: list[Path], target: Path, draw: np.random.Generator) -> Path:
    """A damaged copy of a log (a file or a bag's folder) under `target`; the path to give to the importer."""
    if source.is_dir():
        path = target / source.name
        shutil.copytree(source, path)
        inside = sorted(p for p in path.iterdir() if p.is_file())
        chosen = inside[int(draw.integers(len(inside)))]
        if draw.random() < 0.05:
            chosen.unlink()
        else:
            chosen.write_bytes(mutated(chosen.read_bytes(), others, draw))
        return path
    name = source.name if draw.random() < 0.95 else others[int(draw.integers(len(others)))].name
    path = target / name
    path.write_bytes(mutated(source.read_bytes(), others, draw))
    meta = source.with_name(f"{source.stem}.meta.yaml")
    if meta.is_file():
        text = meta.read_bytes()
        (target / meta.name).write_bytes(mutated(text, others, draw) if draw.random() < 0.2 else text)
    if name.endswith(".bbl") and draw.random() < 0.5:
        return path.with_name(f"{name}#{int(draw.integers(0, 4))}")
    return path


def mutated(data: bytes, others: list[Path], draw: np.random.Generator) -> bytes:
    """One to four random changes."""
    out = bytearray(data)
    for _ in range(1 + int(draw.geometric(0.5)) % 4):
        size = len(out)
        if size == 0:
            return bytes(out)
        # headers stand at the start (or the end), and most of a file is samples
        reach = int(min(size, draw.choice([200, 3000, size])))
        place = int(draw.integers(reach)) if draw.random() < 0.85 else size - 1 - int(draw.integers(reach))
        length = int(min(draw.geometric(0.05), size - place))
        kind = int(draw.integers(11))
        if kind == 0:
            out[place] ^= 1 << int(draw.integers(8))
        elif kind == 1:
            out[place : place + length] = draw.bytes(length)
        elif kind == 2:
            del out[place : place + length]
        elif kind == 3:
            out[place:place] = draw.bytes(length)
        elif kind == 4:
            del out[place:]
        elif kind == 5:
            out[place : place + length] = bytes([int(draw.choice([0, 0xFF, 0x7F, 0x80]))]) * length
        elif kind == 6:
            out[place:place] = out[place : place + 20 * length]
        elif kind == 7:
            value = draw.choice([np.nan, np.inf, -np.inf, 3e38, -1e-30, 0.0])
            special = np.array([value], dtype=draw.choice(["<f4", "<f8"]))
            out[place : place + special.itemsize] = special.tobytes()
        elif kind == 8:
            found = list(re.finditer(rb"-?\d+", bytes(out[:6000])))
            if found:
                one = found[int(draw.integers(len(found)))]
                out[one.start() : one.end()] = _NUMBERS[int(draw.integers(len(_NUMBERS)))]
        elif kind == 9:
            other = others[int(draw.integers(len(others)))]
            if other.is_file():
                more = other.read_bytes()
                out = out + more if draw.random() < 0.5 else out[:place] + more[len(more) // 2 :]
        else:
            lines = bytes(out).split(b"\n")
            a, b = (int(v) for v in draw.integers(len(lines), size=2))
            lines[a], lines[b] = lines[b], lines[a]
            out = bytearray(b"\n".join(lines))
    return bytes(out)


def run_case(case: int, logs: list[Path], work: Path) -> dict[str, Any]:
    """What became of one case: its reader, and 'flight', 'refused' or what went wrong."""
    draw = np.random.default_rng(case)
    source = logs[case % len(logs)]
    folder = work / "log"
    out = work / "out"
    for place in (folder, out):
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
    path = damaged(source, logs, folder, draw)
    before = sorted(p.relative_to(folder) for p in folder.rglob("*"))
    said: dict[str, Any] = {"case": case, "log": source.name, "outcome": "flight"}
    signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            said |= _one(path, out, draw)
    except BaseException as error:
        said |= {
            "outcome": "failed",
            "error": f"{type(error).__name__}: {error}"[:300],
            "trace": traceback.format_exc(),
        }
    finally:
        signal.alarm(0)
    # sqlite may leave its journal only while it is open
    after = sorted(p.relative_to(folder) for p in folder.rglob("*"))
    if after != before:
        said |= {"outcome": "failed", "error": f"files beside the log: {set(after) ^ set(before)}"}
    return said


def _one(path: Path, out: Path, draw: np.random.Generator) -> dict[str, Any]:
    from infotraj.checking import examine, load
    from infotraj.errors import InfotrajError
    from infotraj.importing import import_log

    way = draw.random()
    damaged_too = bool(draw.random() < 0.6)
    mapping = mapping_of(path)
    try:
        if way < 0.7:
            import_log(path, mapping, allow_damaged=damaged_too)
        elif way < 0.85 and mapping is None:
            return _by_command(path, out, damaged_too)
        else:
            examine(load(path, mapping))
    except InfotrajError as error:
        line = str(error)
        if "\n" in line or len(line) > LONGEST_LINE or not line:
            return {"outcome": "failed", "error": f"not one line: {line[:300]!r}"}
        return {"outcome": "refused"}
    return {}


def _by_command(path: Path, out: Path, damaged_too: bool) -> dict[str, Any]:
    from click.testing import CliRunner

    from infotraj.errors import InfotrajError
    from infotraj.importing.command import import_command

    target = out / "flight.parquet"
    extra = ["--allow-damaged"] if damaged_too else []
    found = CliRunner().invoke(import_command, [str(path), "-o", str(target), "--explain", *extra])
    left = sorted(p.name for p in out.iterdir())
    if isinstance(found.exception, InfotrajError):  # the command line prints it as one line
        found.exit_code = found.exception.exit_status
    elif found.exception is not None and not isinstance(found.exception, SystemExit):
        raise found.exception
    if found.exit_code == 0 and left == ["flight.parquet"]:
        return {}
    if found.exit_code in (1, 2, 3) and not left:
        return {"outcome": "refused"}
    return {"outcome": "failed", "error": f"exit {found.exit_code}, left {left}: {found.output[-200:]}"}


def mapping_of(path: Path) -> Any:
    """The mapping that a log of no known layout needs; None where it is recognised by itself."""
    from test_import_bytes import RIGID
    from writers_table import NED_MAPPING

    from infotraj.importing import parse_mapping

    given = {"hand.mcap": RIGID, "ned.csv": NED_MAPPING}.get(path.name)
    return None if given is None else parse_mapping(given)


class Hang(BaseException):
    """A case took too long; no Exception, because readers turn those into refusals."""


def _too_long(*_: Any) -> None:
    raise Hang(f"more than {SECONDS} s")


def warmed(logs: list[Path]) -> None:
    """Imports every whole log once, so that no case waits for a compiler."""
    from infotraj.errors import InfotrajError
    from infotraj.importing import import_log

    for log in logs:
        with contextlib.suppress(InfotrajError):
            import_log(log, mapping_of(log), allow_damaged=True)


def fuzz(start: int, count: int, logs: list[Path], report: Path) -> None:
    """Cases start to start + count, each written to `report` (JSON lines) before and after it runs."""
    with tempfile.TemporaryDirectory() as work, open(report, "a") as file:
        for case in range(start, start + count):
            file.write(json.dumps({"case": case, "log": logs[case % len(logs)].name, "outcome": "begun"}) + "\n")
            file.flush()
            file.write(json.dumps(run_case(case, logs, Path(work))) + "\n")


def main() -> int:
    """Runs for the asked time and prints a table by log; exit status 1 where a case failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--case", type=int)
    parser.add_argument("--report", type=Path, default=None)
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="fuzz_"))
    try:
        (folder / "logs").mkdir()
        logs = seeds(folder / "logs")
        if options.case is not None:
            print(json.dumps(run_case(options.case, logs, folder), indent=1).replace("\\n", "\n"))
            return 0
        warmed(logs)
        report = options.report or folder / "report.jsonl"
        until, start, crashes = time.monotonic() + 60 * options.minutes, options.seed * 10_000_000, 0
        while time.monotonic() < until:
            child = os.fork()
            if child == 0:
                status = 1
                try:
                    fuzz(start, CASES, logs, report)
                    status = 0
                finally:
                    os._exit(status)
            _, status = os.waitpid(child, 0)
            crashes += status != 0
            start += CASES
        return _summary(report, crashes)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _summary(report: Path, crashes: int) -> int:
    lines = [json.loads(line) for line in report.read_text().splitlines()]
    last = {line["case"]: line for line in lines}
    table: dict[str, dict[str, int]] = {}
    for line in last.values():
        row = table.setdefault(line["log"], {"flight": 0, "refused": 0, "failed": 0, "begun": 0})
        row[line["outcome"]] += 1
    for log, row in sorted(table.items()):
        print(f"{log:28s} {row}")
    bad = [line for line in last.values() if line["outcome"] in ("failed", "begun")]
    for line in bad[:40]:
        print(f"case {line['case']} ({line['log']}): {line.get('error', 'the process died')}")
    print(f"{len(last)} cases, {len(bad)} failed, {crashes} processes died")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
