"""The fingerprint of a stage: a hash over the code that the stage can run, so that an edit reruns what it touches.

A workflow engine sees that a script changed, not that the library behind it did. The fingerprint of a module covers its
own source and that of every infotraj module that it imports, directly or not. It is read from the files and nothing is
executed: the imports are those that the syntax tree shows, also inside functions (imports by a computed name are not
seen). What is hashed is the syntax tree without docstrings, so comments, docstrings and layout do not count.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from pathlib import Path

from infotraj.errors import InputError, problem

PACKAGE = Path(__file__).resolve().parent


def fingerprint(module: str, *, package: Path = PACKAGE) -> str:
    """Hash (16 hexadecimal digits) of the code of `module` and of all that it imports from its own package.

    module: dotted name, such as "infotraj.experiment.paper.models"; package: the folder of the top-level package. The
    same code has the same fingerprint anywhere, under one minor version of Python. InputError where there is no such
    module.
    """
    digest = hashlib.sha256()
    for name, path in sorted(sources(module, package=package).items()):
        digest.update(f"{name} {_parse(path.read_text(encoding='utf-8'), str(path))[0]}\n".encode())
    return digest.hexdigest()[:16]


def sources(module: str, *, package: Path = PACKAGE) -> dict[str, Path]:
    """The modules that importing and running `module` can load, its own included: {dotted name: file}.

    A package counts with its __init__.py, since importing a module runs those of all its parents.
    """
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        path = _file(name, package)
        if path is None:
            if name == module:
                raise InputError(problem(f"no module {module}", f"a module below {package.name}", "Check its name."))
            continue
        found[name] = path
        parents = name.split(".")[:-1]
        waiting += [".".join(parents[: k + 1]) for k in range(len(parents))]
        anchor = name if path.name == "__init__.py" else name.rpartition(".")[0]
        for level, target in _parse(path.read_text(encoding="utf-8"), str(path))[1]:
            waiting.append(target if level == 0 else _absolute(anchor, level, target))
    return found


def _file(name: str, package: Path) -> Path | None:
    """The file of a module below `package`; None for other packages, and for names inside a module."""
    top, *rest = name.split(".")
    if top != package.name:
        return None
    base = package.joinpath(*rest)
    for path in (base / "__init__.py", base.with_suffix(".py")):
        if path.is_file():
            return path
    return None


def _absolute(anchor: str, level: int, target: str) -> str:
    parts = anchor.split(".")
    return ".".join([*parts[: len(parts) - level + 1], *([target] if target else [])])


@functools.lru_cache(maxsize=1024)
def _parse(text: str, path: str) -> tuple[str, tuple[tuple[int, str], ...]]:
    """Hash of the code without docstrings, and its imports as (relative level, dotted name).

    `from a import b` gives both a and a.b, since only the files tell whether b is a module.
    """
    try:
        tree = ast.parse(text)
    except SyntaxError as error:
        raise InputError(problem(f"{path}, line {error.lineno}: {error.msg}", "valid Python", "Correct it.")) from error
    imports: list[tuple[int, str]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imports += [(0, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            imports.append((node.level, base))
            imports += [(node.level, f"{base}.{alias.name}" if base else alias.name) for alias in node.names]
        elif isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            _drop_docstring(node)
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(imports)


def _drop_docstring(node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> None:
    first = node.body[0] if node.body else None
    if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
        node.body = node.body[1:]
