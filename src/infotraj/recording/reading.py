"""What a recording holds, read back, and a hash of it: the file's bytes are never the same twice."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
from rerun.chunk import RrdReader

from infotraj.errors import InputError, problem
from infotraj.recording.stream import TIMELINE
from infotraj.rotations import Array

_ROW_ID = "rerun.controls.RowId"


def read_back(path: str | Path) -> dict[str, dict[str, Array | list]]:
    """Entity path (without the leading slash) to its columns: `t` (n,) s and one entry a component, in time order.

    A component whose rows all have one shape is an array (n, ...), with the axis of one instance a row removed; any
    other is a list. A static component is the single value. InputError where the file is not a recording.
    """
    rows: dict[str, dict[str, list]] = {}
    try:
        chunks = [chunk.to_record_batch() for chunk in RrdReader(str(path)).stream()]
        paths = [chunk.entity_path for chunk in RrdReader(str(path)).stream()]
    except (OSError, ValueError, RuntimeError) as error:
        first = str(error).splitlines()[0]
        raise InputError(
            problem(f"{path}: cannot be read ({first})", "a rerun recording", "Write it again.")
        ) from error
    for entity, batch in zip(paths, chunks, strict=True):
        times = None
        if TIMELINE in batch.schema.names:
            column = batch.column(TIMELINE)
            times = np.asarray(column.cast("int64")).astype(float) * 1e-9
        for name in batch.schema.names:
            if name in (_ROW_ID, TIMELINE):
                continue
            values = batch.column(name).to_pylist()
            pairs = [(None if times is None else times[i], v) for i, v in enumerate(values) if v is not None]
            rows.setdefault(entity.lstrip("/"), {}).setdefault(name, []).extend(pairs)
    return {entity: _columns(components) for entity, components in rows.items()}


def content_hash(path: str | Path) -> str:
    """sha256 of what a recording says (entities, times, values), apart from row identities, order and layout."""
    digest = hashlib.sha256()
    for entity, columns in sorted(read_back(path).items()):
        for name, values in sorted(columns.items()):
            content = values.tolist() if isinstance(values, np.ndarray) else values
            digest.update(f"{entity}\0{name}\0{content!r}\n".encode())
    return digest.hexdigest()


def _columns(components: dict[str, list]) -> dict[str, Array | list]:
    result: dict[str, Array | list] = {}
    for name, pairs in components.items():
        if pairs and pairs[0][0] is None:
            result[name] = pairs[-1][1]
            continue
        pairs = sorted(pairs, key=lambda pair: pair[0])
        result[TIMELINE] = np.array([t for t, _ in pairs])
        values = [v[0] if isinstance(v, list) and len(v) == 1 else v for _, v in pairs]
        shapes = {np.shape(v) for v in values}
        result[name] = np.array(values, dtype=float) if len(shapes) == 1 else values
    return result
