#!/usr/bin/env python3
"""Do the tests see errors? Puts each error of `deliberate_errors.yaml` into a copy of the library and runs its tests.

usage: .ci/deliberate_errors.py [--only WORD] [--list]

Prints a line an error: caught, caught by a long test alone, or not at all. Exit status 1 where one was not caught or
does not apply. Takes about 5 s an error, more where long tests are asked. Nothing in the checkout is changed.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

TOP = Path(__file__).resolve().parents[1]
LIST = Path(__file__).with_suffix(".yaml")
PASSED, FAILED, NONE_RUN = 0, 1, 5
WORDS = {"not long": "caught", "long": "caught by a long test alone"}


def read() -> list[dict]:
    """The errors: path (below the package), before, after, tests (below tests/)."""
    return yaml.safe_load(LIST.read_text(encoding="utf-8"))


def changed(error: dict, package: Path) -> tuple[Path, str]:
    """The file of an error and its text with the error in it. ValueError where `before` does not stand there once."""
    path = package / error["path"]
    text = path.read_text(encoding="utf-8")
    count = text.count(error["before"])
    if count != 1:
        raise ValueError(f"{error['path']}: {error['before']!r} stands there {count} times; expected once")
    return path, text.replace(error["before"], error["after"])


def caught(error: dict, source: Path) -> str:
    """Which tests of an error fail with it in the library below `source`, of WORDS. RuntimeError where none runs."""
    path, text = changed(error, source / "infotraj")
    before = path.read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    # What was compiled from the file as it was, and what calls it, is compiled again.
    compiled = "njit" in before
    if compiled:
        _forget(source)
    tests = [f"tests/{name}" for name in error["tests"]]
    call = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts="]
    environment = os.environ | {"PYTHONPATH": str(source), "PYTHONDONTWRITEBYTECODE": "1"}
    seen = "NOT CAUGHT"
    try:
        for marked, words in WORDS.items():
            done = subprocess.run(
                [*call, "-m", marked, *tests], cwd=TOP, env=environment, capture_output=True, text=True
            )
            if done.returncode == FAILED:
                seen = words
                break
            if done.returncode not in (PASSED, NONE_RUN):
                said = f"{done.stdout[-2000:]}{done.stderr}"
                raise RuntimeError(f"{error['path']}: pytest ended with {done.returncode}\n{said}")
    finally:
        path.write_text(before, encoding="utf-8")
        if compiled:
            _forget(source)
    return seen


def _forget(source: Path) -> None:
    for path in source.rglob("*.nb[ic]"):
        path.unlink()


def main() -> int:
    """Runs all errors, or those that `--only` names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="a word of the path or of the line")
    parser.add_argument("--list", action="store_true", help="what would be tried, and nothing more")
    given = parser.parse_args()
    errors = [e for e in read() if given.only in e["path"] or given.only in e["before"]]
    counts = dict.fromkeys([*WORDS.values(), "NOT CAUGHT"], 0)
    with tempfile.TemporaryDirectory(prefix="deliberate-errors-") as folder:
        source = Path(folder) / "src"
        if not given.list:
            shutil.copytree(TOP / "src", source)
        for number, error in enumerate(errors, 1):
            line = f"{number}/{len(errors)} {error['path']}: {error['before'].strip()} -> {error['after'].strip()}"
            if given.list:
                print(line)
                continue
            begun = time.monotonic()
            seen = caught(error, source)
            print(f"{line}: {seen} ({time.monotonic() - begun:.0f} s)", flush=True)
            counts[seen] += 1
    if not given.list:
        print(f"of {len(errors)} deliberate errors: {', '.join(f'{n} {words}' for words, n in counts.items())}")
    return 1 if counts["NOT CAUGHT"] else 0


if __name__ == "__main__":
    sys.exit(main())
