"""Commands that are suggested: they run as they stand, on what the command that suggests them was given."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

# What says how flights are read and judged: the next command reads and judges them alike.
_REPEATED = (
    "--effects-from", "--window", "--force-from", "--matters", "--seconds", "--from", "--to", "--command-steps",
    "--accept", "--seed",
)  # fmt: skip


def quoted(*words: object) -> str:
    """Paths and settings as a shell takes them, each as one argument that no command takes for an option."""
    return " ".join(shlex.quote(f"./{w}" if str(w).startswith("-") else str(w)) for w in words)


def again(command: str, *, command_steps: int = 1, reference: Sequence[object] = ()) -> str:
    """The options that the running command was given and the next one, `command`, has too, each after a space.

    command_steps: how sparse commands were read where no option says so; reference: the healthy flights that were used,
    for a command that takes any. Without a running command that is all.
    """
    given = _given()
    if command_steps > 1:
        given.setdefault("--command-steps", command_steps)
    if not given and not reference:
        return ""  # what the next command takes need not be read then: its module is not loaded
    known = _options(command)
    words = [w for name, value in given.items() if known is None or name in known for w in _words(name, value)]
    if reference and (known is None or "--reference" in known):
        words.append(f"--reference {quoted(*reference)}")
    return "".join(f" {w}" for w in words)


def unused(name: str) -> str:
    """A name for a new file in the working folder that no file has: this one, else with a number."""
    path, number = Path(name), 2
    while path.exists():
        path = Path(name).with_stem(f"{Path(name).stem}-{number}")
        number += 1
    return str(path)


def _given() -> dict[str, Any]:
    context = click.get_current_context(silent=True)
    if context is None:
        return {}
    options = {_long(p): p.name for p in context.command.params if isinstance(p, click.Option) and p.name}
    typed = {o: n for o, n in options.items() if context.get_parameter_source(n) is ParameterSource.COMMANDLINE}
    return {option: context.params[typed[option]] for option in _REPEATED if option in typed}


def _options(command: str) -> set[str] | None:
    """The options of a command of the same command line; None where no command line runs."""
    context = click.get_current_context(silent=True)
    if context is None:
        return None
    front = context.find_root().command
    found = front.get_command(context, command) if isinstance(front, click.Group) else None
    return None if found is None else {_long(p) for p in found.params if isinstance(p, click.Option)}


def _long(option: click.Option) -> str:
    return max(option.opts, key=len)


def _words(name: str, value: Any) -> Iterable[str]:
    for one in value if isinstance(value, tuple) else (value,):
        text = quoted(one) if isinstance(one, Path) else shlex.quote(str(one).removesuffix(".0"))
        yield f"{name} {text}"
