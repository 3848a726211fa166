"""Results on a terminal: no line beyond its width, nothing lost; in a pipe every line whole."""

import os
import pty
import subprocess
import sys
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from infotraj.terminal import folded

VEHICLE = "config/vehicles/nanobench_uncalibrated.yaml"
WORDS = st.lists(st.text("ab,.-", min_size=1, max_size=15), min_size=1, max_size=40).map(" ".join)
TEXTS = st.lists(st.tuples(st.integers(0, 8), WORDS).map(lambda one: " " * one[0] + one[1]), max_size=4).map("\n".join)


@given(TEXTS, st.integers(40, 120))
def test_no_line_is_longer_and_no_word_is_lost(text, width):
    made = folded(text, width)
    assert made.split() == text.split()
    assert max(map(len, made.split("\n"))) <= width
    assert folded(made, width) == made


@pytest.mark.parametrize("width", [40, 80])
def test_a_sentence_ends_at_the_edge_and_goes_on_further_in(width):
    lines = folded("  " + "word " * 60, width).split("\n")
    assert max(map(len, lines)) <= width < max(map(len, lines)) + len(" word")
    assert lines[0].startswith("  word")
    assert {line[:7] for line in lines[1:]} == {"      w"}


def test_columns_keep_their_distances_and_what_fits_is_left_alone():
    row = f"{'effect':<20}{'rise':>9}{'better':>30}  {'x=1 ' * 10}"
    assert folded(row, 80).startswith(row[:61])
    assert folded("a  b \n", 80) == "a  b \n"


def run(code, **kwargs):
    return subprocess.run([sys.executable, "-c", code], **kwargs)


def test_only_a_terminal_folds():
    code = "from infotraj.terminal import show; show('word ' * 60)"
    piped = run(code, capture_output=True, text=True).stdout
    assert piped == "word " * 60 + "\n"
    ours, theirs = pty.openpty()
    run(code, stdout=theirs, env={**os.environ, "COLUMNS": "80"})
    os.close(theirs)
    seen = os.read(ours, 4096).decode().split("\r\n")
    os.close(ours)
    assert len(seen) > 3
    assert max(map(len, seen)) <= 80


@pytest.mark.parametrize("words", ["effects", "effects show mass_offset", "data list", f"vehicle check {VEHICLE}"])
def test_a_catalogue_fits_on_a_terminal_and_stays_whole_in_a_pipe(words):
    called = [sys.executable, "-m", "infotraj.cli", *words.split()]
    piped = subprocess.run(called, capture_output=True, text=True, check=True).stdout
    ours, theirs = pty.openpty()
    asked = subprocess.Popen(called, stdout=theirs, stderr=subprocess.DEVNULL, env={**os.environ, "COLUMNS": "80"})
    os.close(theirs)
    seen = b""
    with suppress(OSError), open(ours, "rb", buffering=0) as terminal:  # the terminal's end is an error
        while more := terminal.read(4096):
            seen += more
    assert asked.wait() == 0
    shown = seen.decode().splitlines()
    assert max(map(len, piped.splitlines())) > 80 >= max(map(len, shown))
    assert " ".join(shown).split() == piped.split()


def test_no_command_writes_an_escape_code_to_a_terminal():
    pytest.importorskip("colorama")
    code = "import colorama; colorama.init(); from infotraj.cli import main; main()"
    ours, theirs = pty.openpty()
    subprocess.run([sys.executable, "-c", code, "--version"], stdout=theirs, stderr=theirs, check=True)
    os.close(theirs)
    seen = os.read(ours, 4096)
    os.close(ours)
    assert b"infotraj, version" in seen
    assert b"\x1b" not in seen
