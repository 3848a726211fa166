"""One page over the results of the experiment: figures and tables with captions that quote the configuration."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, StrictUndefined

from infotraj.errors import InputError, problem
from infotraj.report.page import asset
from infotraj.writing import whole

_LINK = re.compile(r"\[([^]]*)\]\(([^)\s]*)\)")


def write_index(
    entries: Sequence[Mapping[str, Any]], recordings: Sequence[str], config: Mapping[str, Any], points: int, path: Path
) -> None:
    """Writes the page, which links to its figures and recordings by relative addresses.

    entries: in order, each with `section`, `title`, `path` (a picture, a Markdown file, or a folder of pictures) and
    `caption` (a file, the caption that Snakemake's own report shows). config, points: what captions quote. InputError
    where there is nothing to show.
    """
    if not entries and not recordings:
        remedy = "Run `snakemake --cores 2` first."
        raise InputError(problem(f"{path.parent}: no results yet", "figures, tables or recordings", remedy))
    captions = Environment(undefined=StrictUndefined)
    quoted = SimpleNamespace(config=config, params=SimpleNamespace(points=points))
    sections: dict[str, list[dict[str, Any]]] = {}
    for entry in entries:
        caption = captions.from_string(Path(entry["caption"]).read_text()).render(snakemake=quoted)
        shown = Path(entry["path"])
        for one in sorted(shown.glob("*.png")) if shown.is_dir() else [shown]:
            title = entry["title"] if one == shown else f"{entry['title']}: {one.stem.replace('_', ' ')}"
            sections.setdefault(entry["section"], []).append(_item(one, title, caption, path.parent))
    page = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    text = page.from_string(asset("index.html")).render(
        sections=sections,
        recordings=[{"name": r, "link": _link(Path(r), path.parent)} for r in recordings],
        css=asset("page.css"),
    )
    with whole(path) as part:
        part.write_text(text, encoding="utf-8")


def _item(path: Path, title: str, caption: str, folder: Path) -> dict[str, Any]:
    item: dict[str, Any] = {"title": title, "caption": " ".join(caption.replace("``", "").replace("`", "").split())}
    if path.suffix == ".md":
        return item | {"blocks": blocks(path.read_text()), "file": _link(path, folder)}
    pdf = path.with_suffix(".pdf")
    return item | {"image": _link(path, folder), "pdf": _link(pdf, folder) if pdf.is_file() else None}


def blocks(markdown: str) -> list[dict[str, Any]]:
    """Markdown as headings, tables and paragraphs: what the result tables are made of. Links become their text."""
    found: list[dict[str, Any]] = []
    for chunk in re.split(r"\n\s*\n", _LINK.sub(r"\1", markdown).strip()):
        lines = [line.strip() for line in chunk.splitlines()]
        while lines and lines[0].startswith("#"):
            found.append({"heading": lines.pop(0).lstrip("# ")})
        if len(lines) > 1 and lines[0].startswith("|") and re.fullmatch(r"[|:\- ]+", lines[1]):
            head, _, *rows = (_cells(line) for line in lines if line.startswith("|"))
            found.append({"head": head, "rows": rows})
        elif lines:
            found.append({"text": _plain(" ".join(lines))})
    return found


def _cells(line: str) -> list[str]:
    return [_plain(cell.strip()) for cell in line.strip().strip("|").split("|")]


def _plain(text: str) -> str:
    return text.replace("**", "").replace("`", "")


def _link(path: Path, folder: Path) -> str:
    return quote(Path(os.path.relpath(path, folder)).as_posix())
