#!/usr/bin/env python3
"""Do the tests see errors? Puts each error of `deliberate_errors.yaml` into a copy of the library and runs its tests.

usage: .ci/deliberate_errors.py [--only WORD] [--list]

Prints a line an error: caught, or the one that no test saw. Exit status 1 where one was not caught or does not apply.
Takes about 20 s an error. Nothing in the checkout is changed.
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
PACKAGE = "src/infotraj"


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


def caught(error: dict, source: Path) -> bool:
    """Whether the tests of an error fail with it in the library below `source`. RuntimeError where none was run."""
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
    try:
        done = subprocess.run([*call, *tests], cwd=TOP, env=environment, capture_output=True, text=True)
    finally:
        path.write_text(before, encoding="utf-8")
        if compiled:
            _forget(source)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{error['path']}: pytest ended with {done.returncode}\n{done.stdout[-2000:]}{done.stderr}")
    return done.returncode == 1


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
    unseen = []
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
            print(f"{line}: {'caught' if seen else 'NOT CAUGHT'} ({time.monotonic() - begun:.0f} s)", flush=True)
            if not seen:
                unseen.append(line)
    if not given.list:
        print(f"{len(errors) - len(unseen)} of {len(errors)} deliberate errors caught")
    return 1 if unseen else 0


if __name__ == "__main__":
    sys.exit(main())
