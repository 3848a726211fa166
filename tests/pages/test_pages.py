"""Commands and outputs in README and pages: what they show is what the commands print."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from writers_ulog import write_ulog

from infotraj.errors import InfotrajError
from infotraj.examples.pages import difference, rewritten, run_page
from infotraj.flight import Flight, read_flight

TOP = Path(__file__).parents[2]
REAL = "docs/tutorial_real.md"
LOGS = "crazyswarm2/logs"
HAS_DATA = (Path(os.environ.get("INFOTRAJ_DATA", "/nonexistent")) / LOGS).is_dir()
needs_data = pytest.mark.skipif(not HAS_DATA, reason=f"INFOTRAJ_DATA names no folder with {LOGS}")
PAGES = ("README.md", "docs/tutorial.md", "docs/commands.md", "docs/python.md")


@pytest.mark.long
@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_shows_is_what_its_commands_print(name):
    ran = run_page((TOP / name).read_text())
    assert ran.blocks
    assert all((TOP / name).parent.joinpath(path).is_file() for path in ran.pictures)
    for block in ran.blocks:
        changed = difference(block.said, block.now)
        assert changed is None, f"{block.commands}: {changed}\n    python -m infotraj.examples.pages {name}"


def test_every_page_with_an_output_is_among_those_that_are_run():
    shown = {
        str(p.relative_to(TOP))
        for p in (TOP / "README.md", *(TOP / "docs").glob("*.md"))
        if "\n```text\n" in p.read_text()
    }
    assert shown == {*PAGES, REAL}


@pytest.mark.long
@needs_data
def test_the_tutorial_on_real_flights_finds_the_load_that_hung_there():
    """Words of real flights may differ at the edge of what is named; what is known of them must not."""
    ran = run_page((TOP / REAL).read_text())
    assert ran.pictures
    said = {block.commands.split()[1]: block.now for block in ran.blocks}
    answer = said["diagnose"].splitlines()
    assert any(line.startswith("suspended_load      Supported") for line in answer)
    mass = float(re.search(r"suspended_load .* mass=([\d.]+)", said["diagnose"])[1])
    length = float(re.search(r"suspended_load .* length=([\d.]+)", said["diagnose"])[1])
    assert mass == pytest.approx(0.005, rel=0.1)
    assert length == pytest.approx(0.5, rel=0.1)
    assert not re.search(r"^wind +(Supported|Not separable)", said["diagnose"], re.MULTILINE)


def test_a_page_is_run_in_its_order_in_one_folder_and_rewritten():
    first = "a\n```sh\necho one > f\nls examples/quad/vehicle.yaml\n```\n```text\nold\n```\n"
    alone = "b\n```sh\nrm f\n```\nthat one has no output below it and is not run\n"
    page = first + alone + "```sh\ncat f; false\n```\n```text\n```\nc\n"
    text = rewritten(page, run_page(page).blocks)
    assert "```text\nexamples/quad/vehicle.yaml\n```\nb" in text
    assert "```text\none\n```\nc" in text
    assert rewritten(text, run_page(text).blocks) == text


def test_a_page_that_copies_the_examples_begins_without_them():
    page = "```sh\ninfotraj examples examples\n```\n```text\n```\n"
    (block,) = run_page(page).blocks
    assert "already" not in block.now
    assert "examples/quad: " in block.now
    # One that is not run copies nothing.
    alone = "```sh\ninfotraj examples examples\n```\nb\n```sh\nls examples\n```\n```text\n```\n"
    assert run_page(alone).blocks[0].now == "quad\nvehicles\n"


def test_a_picture_is_what_a_command_of_the_page_drew():
    page = "```sh\nmkdir figures; printf drawn > figures/a.png\n```\n```text\n```\n![a](pictures/page/a.png)\n"
    assert run_page(page).pictures == {"pictures/page/a.png": b"drawn"}
    with pytest.raises(InfotrajError, match=r"pictures/page/b\.png"):
        run_page(page.replace("/a.png)", "/b.png)"))


@pytest.mark.parametrize(
    ("now", "alike"),
    [
        ("rise 4.7e+05, rotor=3 not 0.001", True),
        ("not rise 4.68e+05, rotor=3 0.004", True),  # the order of words, and what is nearly nothing
        ("rise 4.68e+05, rotor=2 not 0.001", False),
        ("rise 9.0e+05, rotor=3 not 0.001", False),
        ("rise 4.68e+05, tilt=3 not 0.001", False),
        ("rise 4.68e+05, rotor=3 not 0.001\nmore", False),
    ],
)
def test_pages_may_differ_in_digits_and_not_in_words(now, alike):
    assert (difference("rise 4.68e+05, rotor=3 not 0.001", now) is None) == alike


def px4_log(flight, path):
    """A shipped flight as a ULog of PX4: throttles in the place of speeds (of 2200 rad/s), a battery."""
    table = flight.table.copy()
    for k in range(4):
        table[f"cmd_rotor_{k}"] /= 2200.0
    for axis in "xyz":
        table[f"v{axis}"] = np.gradient(table[f"p{axis}"], table["t"])
    write_ulog(Flight(table.assign(battery=15.2)), path)


@pytest.mark.long
def test_every_command_of_the_page_on_ulogs_runs_in_its_order(tmp_path):
    for k in range(3):
        px4_log(read_flight(TOP / f"examples/quad/flight_{k}.parquet"), tmp_path / f"log_{k + 1}.ulg")
    text = (TOP / "docs/my_ulog.md").read_text()
    said = {}
    for block in re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        for command in block.splitlines():
            front = f'infotraj() {{ "{sys.executable}" -m infotraj.cli "$@"; }}\n'
            done = subprocess.run(["bash", "-c", front + command], cwd=tmp_path, capture_output=True, text=True)
            assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
            said[" ".join(command.split()[:3])] = done.stdout
    assert said["infotraj doctor mine.yaml"].count("nothing stands in the way") == 3
    # The file is made of guesses, and the weak rotor is in all flights: it is named, and the guesses are the file's.
    quoted = re.search(r"`(Missing: [\w, ]+\.)`", text)[1]
    assert quoted == "Missing: rotor_effectiveness."
    assert said["infotraj diagnose mine.yaml"].splitlines()[-1] == quoted
