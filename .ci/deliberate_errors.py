#!/usr/bin/env python3
"""Do the tests see errors? Puts each error of `deliberate_errors.yaml` into a copy of the library and runs its tests.

usage: .ci/deliberate_errors.py [--only WORD] [--list] [--draw N --seed S]

Prints a line an error: caught, caught by a long test alone, or not at all. Exit status 1 where one was not caught or
does not apply. Takes about 5 s an error, more where long tests are asked. Nothing in the checkout is changed.

With `--draw` the errors are drawn at random instead (`drawn_errors.py`), N of those that the seed S gives. They are
shown to the default tests alone: first to those that import the module, then to the other tests of its room, then to
those elsewhere that import the room. A caught one takes 5 to 30 s, one that survives some minutes.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import yaml
from drawn_errors import draw

TOP = Path(__file__).resolve().parents[1]
LIST = Path(__file__).with_suffix(".yaml")
PASSED, FAILED, NONE_RUN = 0, 1, 5
WORDS = {"not long": "caught", "long": "caught by a long test alone"}
NOT = "NOT CAUGHT"
MOST = 900  # s: a test that runs longer does not end


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
    tests = [f"tests/{name}" for name in error["tests"]]
    with _put(path, text, source):
        for marked, words in WORDS.items():
            if _fails(tests, marked, source):
                return words
    return NOT


def caught_drawn(error: dict, source: Path) -> str:
    """Which of the nearby default tests see a drawn error: the words of `near`, or NOT."""
    with _put(source / "infotraj" / error["path"], error["text"], source):
        for words, tests in near(error["path"]).items():
            if tests and _fails(tests, "not long", source):
                return f"caught by tests {words}"
    return NOT


def near(path: str) -> dict[str, list[str]]:
    """The test files for a file of the library, in the order in which they are asked."""
    room, module = path.split("/")[0], path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    parent, _, name = f"infotraj.{module}".rpartition(".")
    imports = re.compile(rf"\binfotraj\.{re.escape(module)}\b|\bfrom {re.escape(parent)} import [^\n]*\b{name}\b")
    texts = {str(f.relative_to(TOP)): f.read_text(encoding="utf-8") for f in sorted((TOP / "tests").rglob("test_*.py"))}
    first = [f for f, text in texts.items() if imports.search(text)]
    second = [f for f in texts if f.startswith(f"tests/{room}/") and f not in first]
    third = [f for f, t in texts.items() if re.search(rf"\binfotraj\.{room}\b", t) and f not in first + second]
    return {"that import it": first, "of its room": second, "that import the room": third}


@contextmanager
def _put(path: Path, text: str, source: Path) -> Iterator[None]:
    """A file as the text for a while. What was compiled from it as it was, and what calls it, is compiled again."""
    before = path.read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    if "njit" in before:
        _forget(source)
    try:
        yield
    finally:
        path.write_text(before, encoding="utf-8")
        if "njit" in before:
            _forget(source)


def _fails(tests: list[str], marked: str, source: Path) -> bool:
    """Whether a test fails, or does not end, with the library below `source`."""
    call = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts="]
    environment = os.environ | {"PYTHONPATH": str(source), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            [*call, "-m", marked, *tests], cwd=TOP, env=environment, capture_output=True, text=True, timeout=MOST
        )
    except subprocess.TimeoutExpired:
        return True
    # A module that cannot even be imported ends the collection: pytest calls that an interruption.
    if done.returncode == FAILED or "error during collection" in done.stdout or "errors during" in done.stdout:
        return True
    if done.returncode not in (PASSED, NONE_RUN):
        raise RuntimeError(f"{tests}: pytest ended with {done.returncode}\n{done.stdout[-2000:]}{done.stderr}")
    return False


def _forget(source: Path) -> None:
    for path in source.rglob("*.nb[ic]"):
        path.unlink()


def main() -> int:
    """Runs all errors, those that `--only` names, or those that are drawn."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="a word of the path or of the line")
    parser.add_argument("--list", action="store_true", help="what would be tried, and nothing more")
    parser.add_argument("--draw", type=int, default=0, metavar="N", help="draw N errors at random instead")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    given = parser.parse_args()
    tried = draw(TOP / "src" / "infotraj", given.draw, given.seed) if given.draw else read()
    errors = [e for e in tried if given.only in e["path"] or given.only in e["before"]]
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="deliberate-errors-") as folder:
        source = Path(folder) / "src"
        if not given.list:
            shutil.copytree(TOP / "src", source)
        for number, error in enumerate(errors, 1):
            where = f"{error['path']}:{error['line']}" if given.draw else error["path"]
            line = f"{number}/{len(errors)} {where}: {error['before'].strip()} -> {error['after'].strip()}"
            if given.list:
                print(line)
                continue
            begun = time.monotonic()
            seen = (caught_drawn if given.draw else caught)(error, source)
            print(f"{line}: {seen} ({time.monotonic() - begun:.0f} s)", flush=True)
            counts[seen] += 1
    if not given.list:
        print(f"of {len(errors)} deliberate errors: {', '.join(f'{n} {words}' for words, n in counts.items())}")
    return 1 if counts[NOT] else 0


if __name__ == "__main__":
    sys.exit(main())
