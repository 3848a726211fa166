"""A log is not loaded whole: memory follows the asked numbers, not the file."""

from __future__ import annotations

import gc
import tracemalloc
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from flights_made import made_flight
from rosbags.rosbag2 import StoragePlugin
from writers_bag import Writer1, Writer2, messages, typestore

from infotraj.importing import import_log

FLIGHT = made_flight(0.6)


def _with_camera(path: Path, ros: Literal[1, 2], storage: StoragePlugin | None, pictures: int) -> Path:
    store = typestore(ros)
    kind = "sensor_msgs/msg/CompressedImage"
    writer: Any = Writer1(path) if ros == 1 else Writer2(path, version=9, storage_plugin=storage)  # type: ignore[arg-type]
    with writer:
        connections: dict[str, Any] = {}
        for k, (topic, name, ns, message) in enumerate(messages(FLIGHT, store, ros, 10**12)):
            entries = [(topic, name, message)]
            if k < pictures:
                picture = np.full(1 << 20, k, np.uint8)
                entries.append(("/camera", kind, store.types[kind](header=message.header, format="", data=picture)))
            for where, which, content in entries:
                if where not in connections:
                    connections[where] = writer.add_connection(where, which, typestore=store)
                raw = store.serialize_ros1(content, which) if ros == 1 else store.serialize_cdr(content, which)
                writer.write(connections[where], ns, raw)
    return path


@pytest.mark.parametrize(
    ("name", "ros", "storage"),
    [("a.bag", 1, None), ("mcap", 2, StoragePlugin.MCAP), ("sqlite", 2, StoragePlugin.SQLITE3)],
)
def test_pictures_cost_no_memory(name: str, ros: Literal[1, 2], storage: Any, tmp_path: Path) -> None:
    path = _with_camera(tmp_path / name, ros, storage, 40)
    import_log(path)  # the modules' own memory comes first
    gc.collect()
    tracemalloc.start()
    try:
        found = import_log(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(found.table) == len(FLIGHT.table)
    # 3 MB alone; what other threads of the process and its garbage take meanwhile counts along.
    assert peak < 20e6, f"{peak / 1e6:.1f} MB for 40 MB of pictures"
