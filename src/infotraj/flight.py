"""The flight table: one row a sample, the columns and units of docs/files.md, read and written without loss."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from infotraj.arguments import AnyPath, as_path
from infotraj.digest import sha256 as sha256
from infotraj.errors import InputError, problem
from infotraj.rotations import Array
from infotraj.sparse_commands import COMMAND_STEPS, MOST_STEPS
from infotraj.suggested import quoted
from infotraj.text_rows import header, row_delimiters, uneven_row
from infotraj.writing import whole

POSITION = ("px", "py", "pz")
ATTITUDE = ("qw", "qx", "qy", "qz")
VELOCITY = ("vx", "vy", "vz")
RATE = ("wx", "wy", "wz")
SPECIFIC_FORCE = ("ax", "ay", "az")
COMMANDED_FORCE = ("cmd_fx", "cmd_fy", "cmd_fz")
COMMANDED_TORQUE = ("cmd_tx", "cmd_ty", "cmd_tz")
COMMANDED_WRENCH = COMMANDED_FORCE + COMMANDED_TORQUE
REFERENCE_POSITION = ("ref_px", "ref_py", "ref_pz")
REFERENCE_ATTITUDE = ("ref_qw", "ref_qx", "ref_qy", "ref_qz")

PART = "infotraj: part"  # metadata of a part of a flight: s, where it begins and ends. No log has a key of this name

BEGAN = "infotraj: began"  # metadata of a part of a flight: s, when the whole of it begins
TURNED = "infotraj: turned"  # likewise: the body axes (three) about which turns are as recorded, and not predicted

_META_KEY = b"infotraj"


@dataclass(frozen=True)
class Flight:
    """One flight: `table` (a column a channel, NaN where a channel has no sample) and its metadata."""

    table: pd.DataFrame
    meta: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_table(self.table, source=str(self.meta.get("source", "flight")))

    @property
    def t(self) -> Array:
        """Time (s), (n,)."""
        return self.table["t"].to_numpy(dtype=float)

    def has(self, *columns: str) -> bool:
        """True where every named column exists and holds at least one number."""
        return all(c in self._filled for c in columns)

    @cached_property
    def _filled(self) -> frozenset[str]:
        return frozenset(self.table.columns[self.table.notna().any()])

    def get(self, *columns: str) -> Array:
        """The named columns, (n, len(columns)). InputError names those that are missing."""
        missing = [c for c in columns if c not in self.table]
        if missing:
            raise InputError(
                problem(
                    f"{self.meta.get('source', 'flight')}: columns {', '.join(missing)} are missing",
                    f"{', '.join(columns)}",
                    "Add them to the log or to its mapping.",
                )
            )
        # Column by column: selecting them together copies through an index, which is many times slower.
        found = [self.table[c].to_numpy(dtype=float) for c in columns]
        return np.stack(found, axis=1) if found else np.zeros((len(self.table), 0))

    def numbered(self, prefix: str) -> Array:
        """Columns prefix0, prefix1, ... as (n, count); count is 0 where there are none."""
        names: list[str] = []
        while f"{prefix}{len(names)}" in self.table:
            names.append(f"{prefix}{len(names)}")
        return self.table[names].to_numpy(dtype=float).reshape(len(self.table), len(names))

    def between(self, start: float, stop: float) -> Flight:
        """The rows with start <= t < stop (s)."""
        keep = (self.t >= start) & (self.t < stop)
        return Flight(self.table[keep].reset_index(drop=True), dict(self.meta))

    def write(self, path: AnyPath) -> None:
        """Writes .parquet (metadata inside) or .csv (metadata in NAME.meta.yaml beside it), whole or not at all."""
        path = Path(path)
        if path.suffix not in (".parquet", ".csv"):
            raise InputError(problem(f"{path}", "a name that ends in .parquet or .csv", "Rename it."))
        with ExitStack() as files:  # the table takes its name first: no metadata without it
            if path.suffix == ".csv" and self.meta:
                files.enter_context(whole(meta_path(path))).write_text(yaml.safe_dump(self.meta, sort_keys=False))
            part = files.enter_context(whole(path))
            if path.suffix == ".parquet":
                arrow = pa.Table.from_pandas(self.table, preserve_index=False)
                meta = {**(arrow.schema.metadata or {}), _META_KEY: json.dumps(self.meta).encode()}
                pq.write_table(arrow.replace_schema_metadata(meta), part)
            else:
                self.table.to_csv(part, index=False, float_format="%.17g")
        if path.suffix == ".csv" and not self.meta:
            meta_path(path).unlink(missing_ok=True)  # of the table that was there


def stepped(flight: Flight, count: int) -> Flight:
    """The flight with commands that make `count` steps from one row that holds them to the next; 1: that are held."""
    return Flight(flight.table, {**flight.meta, COMMAND_STEPS: count})


def command_steps(flight: Flight) -> int:
    """The number of these steps. InputError where the metadata hold something else."""
    count = flight.meta.get(COMMAND_STEPS, 1)
    if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= MOST_STEPS:
        source = flight.meta.get("source", "flight")
        what = f"{source}: {COMMAND_STEPS} {count!r} in the metadata"
        raise InputError(
            problem(
                what, f"a whole number from 1 to {MOST_STEPS}: steps from row to row", "Correct it or leave it out."
            )
        )
    return count


def read_flight(path: AnyPath) -> Flight:
    """Reads a flight table (.csv or .parquet). InputError, one line, for anything that is not one."""
    path = as_path("a flight", path)
    if not path.is_file():
        what = "a folder" if path.is_dir() else "there is no such file"
        raise InputError(problem(f"{path}: {what}", "a flight table (.csv or .parquet)", "Check the path."))
    try:
        if path.suffix.lower() == ".parquet":
            arrow = pq.read_table(path)
            meta = json.loads((arrow.schema.metadata or {}).get(_META_KEY, b"{}"))
            # The columns say all: what pandas wrote beside them may be damaged, and is not needed.
            table = arrow.replace_schema_metadata(None).to_pandas()
        elif path.suffix.lower() == ".csv":
            _require_even(path)
            table = pd.read_csv(path)
            meta = yaml.safe_load(meta_path(path).read_text()) if meta_path(path).is_file() else {}
        else:
            model = "Is it a model? One MODEL comes first, before the flights."
            remedy = model if path.suffix in (".yaml", ".yml") else f"infotraj import {quoted(path)} -o flight.parquet"
            raise InputError(problem(f"{path}: ends in '{path.suffix}'", "a flight table (.csv or .parquet)", remedy))
    except InputError:
        raise
    except (OSError, ValueError, pa.ArrowException, yaml.YAMLError, UnicodeDecodeError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(
            problem(
                f"{path}: cannot be read ({first})",
                f"a complete {path.suffix} file",
                "It may be truncated: write it again.",
            )
        ) from error
    meta = {**meta, "source": str(path)} if isinstance(meta, dict) else {"source": str(path)}
    return Flight(table, meta)


def _require_even(path: Path) -> None:
    """InputError where a row of a CSV has more or fewer fields than its header."""
    delimiter, names = header(path)
    expected = row_delimiters(path, delimiter, len(names))
    uneven = uneven_row(path, delimiter, expected)
    if uneven is not None:
        row, fields, is_last = uneven
        where = "the last row" if is_last else f"row {row}"
        left = f"infotraj import {quoted(path)} --allow-damaged -o NEW.parquet"
        remedy = f"Copy it again, or take what is left of it: {left}" if is_last else "Write it again."
        raise InputError(problem(f"{path}: {where} has {fields} fields", f"{expected + 1}", remedy))


def check_table(table: pd.DataFrame, source: str) -> None:
    """InputError unless `table` is a flight table: numeric columns, a finite and increasing time."""
    if "t" not in table:
        columns = ", ".join(map(str, table.columns[:8])) or "no columns"
        raise InputError(
            problem(f"{source}: no column t among {columns}", "a flight table with t in s", "Import the log first.")
        )
    if len(table) < 2:
        raise InputError(problem(f"{source}: {len(table)} rows", "at least 2", "Use a longer log."))
    text = [c for c in table if not pd.api.types.is_numeric_dtype(table[c]) and table[c].notna().any()]
    if text:
        raise InputError(problem(f"{source}: column {text[0]} holds text", "numbers", "Remove or convert the column."))
    t = table["t"].to_numpy(dtype=float)
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise InputError(
            problem(f"{source}: t is not a number in row {bad[0]}", "a finite time in s in every row", "Remove it.")
        )
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        k = back[0]
        raise InputError(
            problem(
                f"{source}: time goes from {t[k]:.6f} to {t[k + 1]:.6f} s at row {k + 1}",
                "a strictly increasing t",
                "Sort the rows or cut the log there.",
            )
        )


def meta_path(path: Path) -> Path:
    """Where the metadata of a flight table in CSV are."""
    return path.with_name(f"{path.stem}.meta.yaml")


def flight_files(path: Path) -> list[Path]:
    """The files of a flight table: the table, and beside a CSV its metadata, there or not."""
    return [path, meta_path(path)] if path.suffix.lower() == ".csv" else [path]
