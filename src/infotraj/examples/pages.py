"""What pages show of commands is what the commands print: `python -m infotraj.examples.pages PAGE...` writes it.

In a page (Markdown) a block ```sh with a block ```text right below it is a command and its output. The commands of a
page run one after another in one new folder that holds `examples` (what `infotraj examples examples` copies), unless
one of them copies it; what they print to both streams replaces the text. So do blocks of ```python, in one session,
with an output below or without.
A picture `pictures/PAGE/NAME.png` of a page is what its commands wrote as `figures/NAME.png`. INFOTRAJ_DATA, where set,
stands in the folder as `data`: real flights, which no page ships.
With --check nothing is written: a page whose words differ from what is printed now fails, and so does one whose numbers
differ by more than a fifth (of the larger; the smallest count as alike).
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click
from click.testing import CliRunner

from infotraj.errors import InfotrajError, problem
from infotraj.examples.command import examples_command

_BLOCK = re.compile(
    r"^```(?P<kind>sh|python)\n(?P<commands>(?:(?!```).*\n)+)```(?:\n\n?```text\n(?P<said>(?:(?!```).*\n)*)```)?$",
    re.MULTILINE,
)
_COPIES = re.compile(r"^infotraj examples ", re.MULTILINE)
_PICTURE = re.compile(r"!\[[^\]]*\]\((?P<path>pictures/[\w-]+/(?P<name>[\w-]+\.png))\)")
_NUMBER = re.compile(r"(?<![\w/.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w/])")
_ALIKE = 0.2  # of the larger of two numbers
_SMALLEST = 0.005


@dataclass(frozen=True)
class Shown:
    """One block of a page: its commands, what the page says they print, what they print now, and where in the page."""

    commands: str
    said: str
    now: str
    start: int
    stop: int


@dataclass(frozen=True)
class Ran:
    """What a page shows after a run: its blocks, and its pictures by their path beside the page."""

    blocks: list[Shown]
    pictures: dict[str, bytes]


def run_page(text: str) -> Ran:
    """Runs the blocks of a page in their order, in one folder.

    InfotrajError where a command ends by a traceback, or did not draw a picture of the page.
    """
    found = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if not any(block["said"] is not None and _COPIES.search(block["commands"]) for block in _BLOCK.finditer(text)):
            CliRunner().invoke(examples_command, [str(folder / "examples"), "-q"], catch_exceptions=False)
        if os.environ.get("INFOTRAJ_DATA"):
            (folder / "data").symlink_to(Path(os.environ["INFOTRAJ_DATA"]).resolve())
        session: dict[str, Any] = {}
        for block in _BLOCK.finditer(text):
            if block["kind"] == "sh" and block["said"] is None:
                continue
            run = partial(_executed, session) if block["kind"] == "python" else _printed
            now = run(block["commands"], folder)
            if block["said"] is None:
                continue
            if "Traceback" in now:
                raise InfotrajError(problem(f"{block['commands'].strip()}: a traceback", "an answer", "Correct it."))
            found.append(Shown(block["commands"], block["said"], now, block.start("said"), block.end("said")))
        pictures = {}
        for picture in _PICTURE.finditer(text):
            drawn = folder / "figures" / picture["name"]
            if not drawn.is_file():
                what = f"{picture['path']}: no command of the page drew figures/{drawn.name}"
                raise InfotrajError(problem(what, "one that does", "Add --figures figures."))
            pictures[picture["path"]] = drawn.read_bytes()
    return Ran(found, pictures)


def rewritten(text: str, blocks: list[Shown]) -> str:
    """The page with what its commands print now."""
    for block in reversed(blocks):
        text = text[: block.start] + block.now + text[block.stop :]
    return text


def difference(said: str, now: str) -> str | None:
    """The first line whose words differ, or whose numbers differ by more than a fifth; None where all are alike.

    The words of a line may come in another order: effects that are not needed are listed by how near they came.
    """
    before, after = said.splitlines(), now.splitlines()
    if len(before) != len(after):
        return f"{len(before)} lines; now {len(after)}"
    for one, other in zip(before, after, strict=True):
        if sorted(_NUMBER.sub("#", one).split()) != sorted(_NUMBER.sub("#", other).split()):
            return f"{one!r}; now {other!r}"
        for a, b in zip(map(float, _NUMBER.findall(one)), map(float, _NUMBER.findall(other)), strict=True):
            if abs(a - b) > max(_ALIKE * max(abs(a), abs(b)), _SMALLEST):
                return f"{one!r}; now {other!r}"
    return None


def _printed(commands: str, folder: Path) -> str:
    front = f'infotraj() {{ "{sys.executable}" -m infotraj.cli "$@"; }}\npython() {{ "{sys.executable}" "$@"; }}\n'
    # What goes through a pipe may come before or after what is said beside it: here it comes before.
    piped = " | " in commands
    done = subprocess.run(
        ["bash", "-c", front + commands],
        cwd=folder,
        env={**os.environ, "INFOTRAJ_CACHE": str(folder / ".cache"), "COLUMNS": "80"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE if piped else subprocess.STDOUT,
        text=True,
        check=False,
    )
    return _without(done.stdout + (done.stderr or ""), folder)


def _executed(session: dict[str, Any], code: str, folder: Path) -> str:
    said = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(said):
        exec(compile(code, "page", "exec"), session)
    return _without(said.getvalue(), folder)


def _without(text: str, folder: Path) -> str:
    lines = text.replace(f"{folder.resolve()}{os.sep}", "").replace(f"{folder}{os.sep}", "").splitlines()
    return "".join(f"{line.rstrip()}\n" for line in lines)


@click.command()
@click.argument("pages", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True))
@click.option("--check", is_flag=True, help="Write nothing; exit status 1 where a page is out of date.")
def main(pages: tuple[Path, ...], check: bool) -> None:
    """Writes under the commands of PAGES what they print, and beside them what they draw."""
    old = 0
    for page in pages:
        text = page.read_text()
        ran = run_page(text)
        blocks = ran.blocks
        for block in blocks:
            changed = difference(block.said, block.now)
            old += changed is not None
            if changed is not None:
                click.echo(f"{page}: {block.commands.strip().splitlines()[0]}: {changed}", err=True)
        if not check:
            page.write_text(rewritten(text, blocks))
            for path, drawn in ran.pictures.items():
                (page.parent / path).parent.mkdir(parents=True, exist_ok=True)
                (page.parent / path).write_bytes(drawn)
        click.echo(f"{page}: {len(blocks)} blocks", err=True)
    sys.exit(1 if check and old else 0)


if __name__ == "__main__":
    main()
