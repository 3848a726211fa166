"""Errors of one line drawn at random: which lines can hold one, and what each would be.

A line is drawn first and then one of its errors, so that a dense line counts no more than a plain one. Left out by
rule, since nothing that is computed depends on them: strings and what stands in them, docstrings, annotations,
decorators, what is raised or warned, how often and how exactly a solver iterates (`EXACTNESS`), and the modules that
only put findings into words or read options (`WORDS`). Constants are not scaled where they are 0, pick an axis or a
place, or only keep a division from zero (`max(x, 1e-12)`).

mutmut and cosmic-ray were not tried: wanted is a draw over rooms that asks the tests nearest to each line first.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Callable, Iterator
from pathlib import Path

ROOMS = ["residual", "informative", "diagnosis", "evaluation", "effects", "dynamics"]
ROOMS += ["importing", "checking", "describing"]
WORDS = {"sentences.py", "command.py", "writing.py"}
EXACTNESS = {"maxiter", "max_nfev", "rtol", "atol", "xtol", "ftol", "gtol", "tol", "ndigits", "digits", "decimals"}
EXACTNESS |= {"check_finite", "overwrite_a", "overwrite_b", "stacklevel", "copy", "strict", "dtype", "encoding"}
SAYING = {"problem", "echo", "warn", "print", "round", "isinstance", "TypeVar", "cast", "Sentence", "lru_cache"}
OPPOSITE = {
    ast.Lt: ">=", ast.GtE: "<", ast.Gt: "<=", ast.LtE: ">", ast.Eq: "!=", ast.NotEq: "==",
    ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
}  # fmt: skip
ARITHMETIC = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Pow: "*"}
PAIRS = "min max, minimum maximum, argmin argmax, any all, floor ceil, nanmin nanmax, sin cos, isfinite isnan"
SWAPPED = {a: b for pair in PAIRS.split(", ") for a, b in (pair.split(), pair.split()[::-1])}
REVERSED = {"sorted", "argsort"}
DROPPED = {"abs", "sqrt", "exp", "log", "cumsum", "square", "clip", "log1p", "expm1", "unwrap", "nan_to_num", "diff"}


def lines(package: Path) -> list[tuple[Path, int]]:
    """All lines of `ROOMS` that can hold an error, in a fixed order."""
    return [(path, line) for path in _files(package) for line in sorted({e[0] for e in errors(path)})]


def draw(package: Path, count: int, seed: int) -> list[dict]:
    """`count` errors on different lines: path below `package`, line, before, after (a line each), text of the file."""
    rng = random.Random(seed)
    drawn = rng.sample(lines(package), count)
    return [_put(path, package, rng.choice([e for e in errors(path) if e[0] == line])) for path, line in drawn]


def errors(path: Path) -> list[tuple[int, int, int, str]]:
    """Line, first and last place in the text of a file, and what would stand there instead."""
    text = path.read_text(encoding="utf-8")
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line.encode()))

    def place(node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset

    def source(node: ast.expr) -> str:
        return text.encode()[slice(*place(node))].decode()

    found = []
    for node in _deciding(ast.parse(text)):
        if isinstance(node, ast.expr):
            found += [(node.lineno, *place(changed), instead) for changed, instead in _of(node, source)]
    return found


def _of(node: ast.expr, source: Callable[[ast.expr], str]) -> Iterator[tuple[ast.expr, str]]:
    """The errors of one node: what is replaced, and by what."""
    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            yield node, f"(({source(left)}) {OPPOSITE[type(op)]} ({source(right)}))"
        case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC and not _joined(left, right):
            yield node, f"(({source(left)}) {ARITHMETIC[type(op)]} ({source(right)}))"
        case ast.BoolOp(op=op, values=values):
            word = " or " if isinstance(op, ast.And) else " and "
            yield node, "(" + word.join(f"({source(v)})" for v in values) + ")"
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            yield node, f"({source(operand)})"
        case ast.Constant(value=bool(value)):
            yield node, str(not value)
        case ast.Constant(value=int() | float() as value) if value:
            yield node, repr(2 * value)
            yield node, "0" if isinstance(value, int) else "0.0"
        case ast.IfExp(test=test, body=body, orelse=other):
            yield node, f"(({source(other)}) if ({source(test)}) else ({source(body)}))"
        case ast.Attribute(value=value, attr="T"):
            yield node, f"({source(value)})"
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name) as called, args=arguments):
            if name in SWAPPED:
                yield called, source(called).removesuffix(name) + SWAPPED[name]
            if name in REVERSED:
                yield node, f"{source(node)}[::-1]"
            if name in DROPPED and arguments:
                yield node, f"({source(arguments[0])})"


def _deciding(node: ast.AST, index: bool = False, above: ast.AST | None = None) -> Iterator[ast.AST]:
    """A node and what is below it, without what is left out."""
    if isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom):
        return
    if isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in SAYING:
        return
    if isinstance(node, ast.Constant) and (index or _guard(node, above)):
        return
    yield node
    for name, value in ast.iter_fields(node):
        if name in {"annotation", "returns", "decorator_list"}:
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.keyword) and (child.arg in EXACTNESS or child.arg == "axis"):
                continue
            if isinstance(child, ast.AST):
                place = isinstance(node, ast.Subscript) and name == "slice"
                place = place or (index and isinstance(node, ast.Slice | ast.Tuple | ast.UnaryOp))
                yield from _deciding(child, place, node)


def _guard(node: ast.Constant, above: ast.AST | None) -> bool:
    """Whether a constant only keeps a division from zero: `max(x, 1e-12)`."""
    called = getattr(above.func, "id", getattr(above.func, "attr", "")) if isinstance(above, ast.Call) else ""
    return called in {"max", "maximum", "clip"} and isinstance(node.value, float) and abs(node.value) < 1e-6


def _joined(*nodes: ast.AST) -> bool:
    """Whether text, lists or types are put together rather than numbers."""
    kinds = ast.JoinedStr | ast.List | ast.Tuple | ast.Dict | ast.ListComp
    return any(isinstance(n, kinds) or (isinstance(n, ast.Constant) and isinstance(n.value, str)) for n in nodes)


def _files(package: Path) -> list[Path]:
    return sorted(p for room in ROOMS for p in (package / room).rglob("*.py") if p.name not in WORDS)


def _put(path: Path, package: Path, error: tuple[int, int, int, str]) -> dict:
    line, begin, end, instead = error
    raw = path.read_text(encoding="utf-8").encode()
    text = (raw[:begin] + instead.encode() + raw[end:]).decode()
    ast.parse(text)
    before, after = (source.split("\n")[line - 1].strip() for source in (raw.decode(), text))
    return {"path": str(path.relative_to(package)), "line": line, "before": before, "after": after, "text": text}
