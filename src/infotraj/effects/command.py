"""`infotraj effects`: the catalogue on the command line."""

from __future__ import annotations

import inspect
import json
from pathlib import Path

import click

from infotraj.effects.base import Effect, Parameter
from infotraj.effects.registry import catalogue, effect_class, effect_files
from infotraj.outputs import require_outputs
from infotraj.terminal import show
from infotraj.writing import whole


@click.group("effects", invoke_without_command=True)
@click.option("--effects", "paths", multiple=True, type=click.Path(path_type=Path), help="File or folder of your own.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the catalogue as JSON.")
@click.pass_context
def effects_command(context: click.Context, paths: tuple[Path, ...], json_path: Path | None) -> None:
    """The catalogue of physical effects that a model may lack."""
    context.obj = paths
    if context.invoked_subcommand is not None:
        return
    require_outputs({"--json": json_path}, {}, {"a file with effects that are read": effect_files(paths)})
    known = catalogue(paths)
    lines: list[str] = []
    place = None
    for cls in known.values():
        if cls.place != place:
            place = cls.place
            lines.append(place)
        names = ", ".join(f"{p.name} ({p.unit})" for p in cls.parameters)
        lines.append(f"  {cls.name:20} {names:42} {_first_line(cls)}")
    show("\n".join(lines))
    if json_path is not None:
        with whole(json_path) as part:
            part.write_text(json.dumps([described(c) for c in known.values()], indent=1) + "\n")
    click.echo("Next: infotraj effects show NAME", err=True)


@effects_command.command("show")
@click.argument("name")
@click.pass_obj
def show_command(paths: tuple[Path, ...], name: str) -> None:
    """One effect: equation, source, parameters, what it needs."""
    cls = effect_class(name, paths)
    lines = [f"{cls.name}: acts on the {cls.place}", "", inspect.getdoc(cls) or "", "", "Parameters"]
    lines += [f"  {_line(p)}" for p in cls.parameters]
    lines += [f"Needs: {', '.join(cls.needs)}"] if cls.needs else []
    lines += [f"Cannot show when {cls.hidden_when}"] if cls.hidden_when else []
    lines += [f"Source: {cls.source}"] if cls.source else []
    show("\n".join(lines))
    click.echo("Next: infotraj diagnose MODEL FLIGHT..., or infotraj add MODEL EFFECT", err=True)


def described(cls: type[Effect]) -> dict:
    """An effect as JSON: name, place, equation, parameters, needs, source."""
    return {
        "name": cls.name,
        "place": cls.place,
        "equation": inspect.getdoc(cls) or "",
        "parameters": [
            {"name": p.name, "unit": p.unit, "absent": p.absent, "size": p.size, "usual": p.scale, "meaning": p.meaning}
            for p in cls.parameters
        ],
        "needs": list(cls.needs),
        "cannot_show_when": cls.hidden_when,
        "source": cls.source,
    }


def _first_line(cls: type[Effect]) -> str:
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def _line(p: Parameter) -> str:
    count = "" if p.size == 1 else (" one a tilt" if p.size == "tilts" else f" x {p.size}")
    absent = "as declared" if p.absent is None else f"{p.absent:g}"
    usual = "" if p.index else f", usual size {p.scale:g}"
    meaning = f": {p.meaning}" if p.meaning else ""
    return f"{p.name} ({p.unit}){count}, absent {absent}{usual}{meaning}"
