"""Message definitions of a bag: those that it carries, else those of a file, else the common ones of ROS.

A definition file is `package/msg/Name.msg` (the folders give the package), a lone `Name.msg`, or one text with
sections that start with `MSG: package/Name`, as bags hold them.
"""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from infotraj.errors import InputError, UsageError, problem

_SECTION = re.compile(r"^=+\s*\nMSG: *(\S+)\s*\n", re.MULTILINE)


class Definitions:
    """Looks message types up: in the given `paths`, then in those shipped with the tool, then in the reader's own."""

    def __init__(self, paths: tuple[Path, ...], ros: int) -> None:
        from rosbags.typesys import Stores, get_typestore

        self._texts: dict[str, str] = {}
        for path in paths:
            self._add(path)
        shipped = Path(str(files("infotraj.importing") / "definitions"))
        self._add(shipped)
        self._common = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_JAZZY).fielddefs

    def store(self, name: str, embedded: Any) -> Any:
        """A type store that knows `name` and all that it refers to; None where no definition is found."""
        from rosbags.typesys import Stores, get_typestore

        types: dict[str, Any] = dict(_parse_embedded(embedded, name))
        waiting = [name]
        while waiting:
            wanted = waiting.pop()
            if wanted not in types:
                found = self._find(wanted)
                if found is None:
                    return None
                types.update({key: value for key, value in found.items() if key not in types})
            waiting += [n for n in _refers_to(types[wanted]) if n not in types]
        store = get_typestore(Stores.EMPTY)
        store.register({key: value for key, value in types.items() if key not in store.fielddefs})
        return store

    def _find(self, name: str) -> dict[str, Any] | None:
        from rosbags.typesys import TypesysError, get_types_from_msg

        package, short = name.split("/")[0], name.split("/")[-1]
        for key in (f"{package}/{short}", short):
            if key in self._texts:
                try:
                    return dict(get_types_from_msg(self._texts[key], name))
                except TypesysError as error:
                    raise InputError(
                        problem(f"definition of {name}: {error}", "a ROS message definition", "Correct the file.")
                    ) from error
        return {name: self._common[name]} if name in self._common else None

    def _add(self, path: Path) -> None:
        if not path.exists():
            raise UsageError(problem(f"definitions {path}: no such file", "a .msg file or a folder", "Check the path."))
        found = [path] if path.is_file() else sorted(path.rglob("*.msg"))
        if not found:
            raise UsageError(problem(f"definitions {path}: no .msg file in it", "package/msg/Name.msg", "Check it."))
        for file in found:
            try:
                text = file.read_text()
            except (OSError, UnicodeDecodeError) as error:
                raise UsageError(problem(f"definitions {file}: {error}", "a text file", "Check it.")) from error
            parts = _SECTION.split(text)
            folders = [part for part in file.parts[:-1] if part != "msg"]
            in_package = file.parent.name == "msg" or path.is_dir()
            own = f"{folders[-1]}/{file.stem}" if in_package and folders else file.stem
            if parts[0].strip():
                self._texts.setdefault(own, text)
                self._texts.setdefault(file.stem, text)
            for full, body in zip(parts[1::2], parts[2::2], strict=True):
                self._texts.setdefault(f"{full.split('/')[0]}/{full.split('/')[-1]}", body)


def _parse_embedded(definition: Any, name: str) -> dict[str, Any]:
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    if definition.format == MessageDefinitionFormat.NONE or not definition.data.strip():
        return {}
    if definition.format == MessageDefinitionFormat.MSG:
        return dict(get_types_from_msg(definition.data, name))
    types: dict[str, Any] = {}
    separator = "=" * 80 + "\n"
    sections = definition.data.split(separator) if definition.data.startswith(separator) else [definition.data]
    for section in sections:
        body = section.split("\n", 1)[1] if section.startswith("IDL: ") else section
        if body.strip():
            types.update(get_types_from_idl(body))
    return types


def _refers_to(definition: Any) -> list[str]:
    from rosbags.interfaces import Nodetype

    found = []
    for _, (kind, detail) in definition[1]:
        inner = detail[0] if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else (kind, detail)
        if inner[0] == Nodetype.NAME:
            found.append(inner[1])
    return found
