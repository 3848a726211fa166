"""The chain of models behind a model file: what each added, and how the error fell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from infotraj.digest import sha256
from infotraj.errors import InputError
from infotraj.models.content import FileReference, ModelFile, read_content
from infotraj.terminal import counted


@dataclass(frozen=True)
class Version:
    """One model of the chain. `state`: "as recorded", "changed since" (its file differs from the hash), "missing" or
    "unreadable"."""

    path: Path
    content: ModelFile | None
    state: str


def history(model: str | Path) -> list[Version]:
    """The versions from the first to this one. InputError where the model itself cannot be read."""
    path = Path(model)
    content: ModelFile | None = read_content(path)
    chain = [Version(path, content, "as recorded")]
    seen = {path.resolve()}
    while content is not None and content.provenance.parent is not None:
        parent = content.provenance.parent
        path = Path(parent.path)
        if path.resolve() in seen:
            break
        seen.add(path.resolve())
        if not path.is_file():
            chain.append(Version(path, None, "missing"))
            break
        state = "as recorded" if sha256(path) == parent.sha256 else "changed since"
        try:
            content = read_content(path)
        except InputError:
            chain.append(Version(path, None, "unreadable"))
            break
        chain.append(Version(path, content, state))
    return chain[::-1]


def as_dict(chain: list[Version]) -> dict[str, Any]:
    """JSON: one entry a version, the first one first."""
    return {
        "versions": [
            {
                "path": str(v.path),
                "state": v.state,
                "effects": [e.model_dump(mode="json") for e in v.content.effects] if v.content else None,
                "provenance": v.content.provenance.model_dump(mode="json", exclude_defaults=True, by_alias=True)
                if v.content
                else None,
            }
            for v in chain
        ]
    }


def as_text(chain: list[Version]) -> str:
    """A line a version: its effects, what made it, and the error of each axis after it."""
    lines = []
    for number, v in enumerate(chain):
        note = "" if v.state == "as recorded" else f" ({v.state})"
        if v.content is None:
            lines.append(f"{number}  {v.path}{note}")
            continue
        effects = ", ".join(e.name for e in v.content.effects) or "no effects"
        lines.append(f"{number}  {v.path}{note}: {effects}")
        p = v.content.provenance
        if p.note:
            lines.append(f"   {p.note}; {counted(len(p.flights), 'flight')}; {p.version}")
        lines += _parts(p.flights)
        for when in ("before", "after", "floor"):
            values = p.error.get(when)
            if values:
                lines.append(f"   {when:<7}" + "  ".join(f"{a} {x:.4g}" for a, x in values.items() if x is not None))
        for entry in p.accepted:
            lines.append(f"   accepted {entry.code}: {entry.what}")
        for effect, how in p.at_bound.items():
            lines.append(f"   {effect}: {how}")
    return "\n".join(lines) + "\n"


def _parts(flights: Sequence[FileReference]) -> list[str]:
    """What of the flights was fitted, where it is not all: one line if it is the same of all, else one of each."""
    limits = [_part(f) for f in flights]
    if not any(limits):
        return []
    if len(set(limits)) == 1:
        return [f"   fitted and judged {limits[0]}"]
    return [f"   {Path(f.path).name}: {part or 'all of it'}" for f, part in zip(flights, limits, strict=True)]


def _part(flight: FileReference) -> str:
    begin = "" if flight.start is None else f"from {flight.start:g} s"
    end = "" if flight.stop is None else f"to {flight.stop:g} s"
    return " ".join(x for x in (begin, end) if x)
