"""Every command that README and pages write exists, with every option that they give it."""

import re
import shlex
from pathlib import Path

import click
import pytest

from infotraj import cli

TOP = Path(__file__).parents[2]
PAGES = [TOP / "README.md", TOP / "CONTRIBUTING.md", *sorted((TOP / "docs").glob("*.md"))]


def written(page: Path) -> list[str]:
    """What follows `infotraj` in code of a page: between backticks, and in lines of code blocks."""
    text = page.read_text()
    shown = re.sub(r"^```text\n.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)  # what commands print
    lines = re.findall(r"^(?: {4,}|)infotraj (.+)$", shown, re.MULTILINE)
    return [line for line in lines if not line.startswith("compares ")] + re.findall(r"`infotraj ([^`]+)`", shown)


def arguments(line: str) -> list[str]:
    line = line.replace("[", " ").replace("]", " ") if "'" not in line and '"' not in line else line
    return [word for word in shlex.split(line.partition(" | ")[0], comments=True) if word != "..."]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_command_of_a_page_exists_with_its_options(page):
    for line in written(page):
        words = arguments(line)
        command = cli.cli.get_command(None, words[0]) if not words[0].startswith("-") else cli.cli
        assert command is not None, f"{page.name}: infotraj {line}"
        rest = words if command is cli.cli else words[1:]
        if isinstance(command, click.Group) and command is not cli.cli and rest and rest[0] in command.commands:
            command, rest = command.commands[rest[0]], rest[1:]
        try:
            command.make_parser(click.Context(command)).parse_args(list(rest))
        except click.UsageError as error:
            pytest.fail(f"{page.name}: infotraj {line}: {error.message}")


def test_the_pages_write_commands_at_all():
    """Else the test above would pass for a pattern that finds nothing."""
    assert sum(len(written(page)) for page in PAGES) > 60
