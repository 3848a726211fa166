"""The next flight, as `infotraj design --json` wrote it, read for the page: nothing that computes is imported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, Field, FiniteFloat, ValidationError

from infotraj.errors import InputError, problem
from infotraj.flight import sha256

Point = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class _File(BaseModel):
    path: str
    sha256: str | None


class _Decided(BaseModel):
    now: FiniteFloat
    again: FiniteFloat
    after: FiniteFloat


class _Number(BaseModel):
    name: str
    standard_error: _Decided


class _Told(BaseModel):
    question: str
    decided: _Decided | None
    numbers: list[_Number]


class _Greatest(BaseModel):
    speed: FiniteFloat
    rate: FiniteFloat


class _Simulated(BaseModel):
    from_reference: FiniteFloat | None


class _Drawn(BaseModel):
    t: list[FiniteFloat] = Field(min_length=2)
    position: list[Point]
    speed: list[FiniteFloat]
    rate: list[FiniteFloat]
    simulated: list[Point] | None


class _Designed(BaseModel):
    """What of a design's JSON the page shows; docs/design.md says what it means."""

    reference: str
    model: _File
    flown: list[_File]
    seconds: FiniteFloat
    greatest: _Greatest
    told: list[_Told]
    simulated: _Simulated | None
    warning: str | None
    hardly_worth: str | None
    fly: bool
    tried: int
    drawn: _Drawn


def read_design(path: Path) -> dict[str, Any]:
    """What `infotraj design --json` wrote, with its own path and hash. InputError for anything else."""
    expected = "what `infotraj design --json` of this version writes"
    try:
        read = _Designed.model_validate_json(path.read_bytes())
    except (OSError, ValidationError) as error:
        what = str(error)
        if isinstance(error, ValidationError):
            first = error.errors()[0]
            what = f"{'.'.join(map(str, first['loc']))} {first['msg']}".strip()
        raise InputError(problem(f"{path}: {what}", expected, "Write it again with `infotraj design`.")) from error
    d = read.drawn
    if {len(d.position), len(d.speed), len(d.rate), len(d.simulated or d.t)} != {len(d.t)}:
        raise InputError(problem(f"{path}: drawn: columns of several lengths", expected, "Write it again."))
    return {**read.model_dump(), "path": str(path), "sha256": sha256(path)}


def require_made_for(design: dict[str, Any], model: str, content: str | None) -> None:
    """InputError where the design is for another model than the page's, of which `content` is the hash; None: none."""
    own = design["model"]
    if None in (own["sha256"], content) or own["sha256"] == content:
        return
    found = f"{design['path']}: designed for {own['path']}, and the page is about {model}, which is another file"
    remedy = "Design again for the page's model, or leave --design out."
    raise InputError(problem(found, "a design and a page of one model", remedy))


def beside(design: dict[str, Any], flights: list[dict[str, Any]]) -> dict[str, Any]:
    """The design on a page about these flights. `others`: what it was made after, where that is not these flights."""
    same = {f["sha256"] for f in design["flown"]} == {f["sha256"] for f in flights}
    return {**design, "others": [] if same else [f["path"] for f in design["flown"]]}
