"""One recording file: columns go in, and it appears under its name whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import ArrayLike

from infotraj.rotations import Array
from infotraj.writing import whole

TIMELINE = "t"


class Columns:
    """Writes channels of one flight, column by column, onto the timeline `t` (s).

    `entities` are those written so far, `spans` the smallest and largest value of each series among them.
    """

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self.entities: set[str] = set()
        self.spans: dict[str, tuple[float, float]] = {}

    def static(self, entity: str, *parts: rr.AsComponents) -> None:
        """What holds at all times: shapes, colours, names."""
        self.entities.add(entity)
        self._stream.log(entity, *parts, static=True)

    def series(self, entity: str, t: ArrayLike, values: ArrayLike, name: str, color: tuple, width: float = 1.5) -> None:
        """One number a sample, values (n,), drawn as the line `name`; samples that are not finite are left out."""
        t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
        there = np.isfinite(values)
        if there.any():
            self.static(entity, rr.SeriesLines(colors=color, names=name, widths=width))
            self.spans[entity] = (float(values[there].min()), float(values[there].max()))
            self._send(entity, t[there], rr.Scalars.columns(scalars=values[there]))

    def pose(self, entity: str, t: Array, *, translation: Array | None = None, attitude: Array | None = None) -> None:
        """A moving frame: translation (n, 3) m and attitude (n, 4) as w, x, y, z."""
        fields: dict[str, Any] = {}
        if translation is not None:
            fields["translation"] = translation
        if attitude is not None:
            fields["quaternion"] = attitude[:, [1, 2, 3, 0]]
        self._send(entity, t, rr.Transform3D.columns(**fields))

    def arrow(self, entity: str, t: Array, origin: Array, vector: Array) -> None:
        """One arrow a sample: origin and vector (n, 3), m, in the frame of the entity."""
        self._send(entity, t, rr.Arrows3D.columns(origins=origin, vectors=vector))

    def _send(self, entity: str, t: Array, columns: rr.ComponentColumnList) -> None:
        self.entities.add(entity)
        self._stream.send_columns(entity, [rr.TimeColumn(TIMELINE, duration=t)], columns)


@contextmanager
def recording(
    path: str | Path, application: str, identity: str, layout: Callable[[Columns], rrb.Blueprint]
) -> Iterator[Columns]:
    """Opens `path` for one recording; `layout` makes its blueprint when all is written.

    `identity` tells the recording from others that are open in the same viewer.
    """
    # Wall-clock timelines and file properties would differ at every run, so neither is written.
    stream = rr.RecordingStream(application, recording_id=identity, send_properties=False)
    stream.set_log_time_enabled(False)
    stream.set_log_tick_enabled(False)
    with whole(Path(path)) as part:
        try:
            stream.save(part)
            columns = Columns(stream)
            yield columns
            stream.send_blueprint(layout(columns))
            stream.flush()
        finally:
            stream.disconnect()
