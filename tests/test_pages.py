"""Commands and outputs in README and pages: what they show is what the commands print."""

from pathlib import Path

import pytest

from infotraj.examples.pages import difference, rewritten, run_page

TOP = Path(__file__).parents[1]
PAGES = ("README.md", "docs/tutorial.md")


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_shows_is_what_its_commands_print(name):
    blocks = run_page((TOP / name).read_text())
    assert blocks
    for block in blocks:
        changed = difference(block.said, block.now)
        assert changed is None, f"{block.commands}: {changed}\n    python -m infotraj.examples.pages {name}"


def test_every_page_with_an_output_is_among_those_that_are_run():
    shown = {
        str(p.relative_to(TOP))
        for p in (TOP / "README.md", *(TOP / "docs").glob("*.md"))
        if "\n```text\n" in p.read_text()
    }
    assert shown == set(PAGES)


def test_a_page_is_run_in_its_order_in_one_folder_and_rewritten():
    first = "a\n```sh\necho one > f\nls examples/quad/vehicle.yaml\n```\n```text\nold\n```\n"
    alone = "b\n```sh\nrm f\n```\nthat one has no output below it and is not run\n"
    page = first + alone + "```sh\ncat f; false\n```\n```text\n```\nc\n"
    text = rewritten(page, run_page(page))
    assert "```text\nexamples/quad/vehicle.yaml\n```\nb" in text
    assert "```text\none\n```\nc" in text
    assert rewritten(text, run_page(text)) == text


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
