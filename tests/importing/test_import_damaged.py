"""Damage that readers of others do not survive: each was found by `fuzz_readers.py`."""

import signal
import struct
from contextlib import contextmanager

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from rosbags.typesys import Stores, get_typestore

from infotraj.errors import InputError
from infotraj.flight import read_flight
from infotraj.importing import import_log
from infotraj.importing.rosbag import _resolves


class Late(BaseException):
    """What no reader takes for damage."""


@contextmanager
def within(seconds):
    """Fails where what is inside takes longer."""

    def stop(*_):
        raise Late(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


# Such that a step back by so much meets the beginning of a message.
@pytest.mark.parametrize("size", [2012, 12002])
def test_a_ulog_whose_last_message_is_longer_than_the_file_ends(tmp_path, size):
    path = tmp_path / "a.ulg"
    key = b"int32_t some_number"
    told = struct.pack("<HBB", 1 + len(key) + 4, ord("I"), len(key)) + key + b"\x01\x00\x00\x00"
    message = struct.pack("<HB", size, 0) + b"\x00" * 40
    path.write_bytes(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + 1000 * told + message)
    with within(20), pytest.raises(InputError, match=str(path)) as raised:
        import_log(path)
    assert "\n" not in str(raised.value)


def test_a_type_that_a_damaged_bag_does_not_define_holds_no_field():
    store = get_typestore(Stores.ROS2_HUMBLE)
    assert _resolves(store, "geometry_msgs/msg/PoseStamped", "header.stamp.sec")
    assert not _resolves(store, "std_msgs/msg/tiee", "sec")


def test_what_pandas_wrote_beside_a_table_need_not_be_whole(tmp_path):
    table = pd.DataFrame({"t": 0.01 * np.arange(10), "px": np.arange(10.0)})
    arrow = pa.Table.from_pandas(table, preserve_index=False)
    damaged = {
        **arrow.schema.metadata,
        b"pandas": arrow.schema.metadata[b"pandas"].replace(b"pandas_type", b"pandas_tyqe"),
    }
    pq.write_table(arrow.replace_schema_metadata(damaged), tmp_path / "a.parquet")
    pd.testing.assert_frame_equal(read_flight(tmp_path / "a.parquet").table, table)


def test_a_time_that_is_a_signalling_nan_is_one_line(tmp_path):
    columns = {name: np.linspace(0.0, 1.0, 200) for name in ("t", "px", "py", "pz", "qw", "qx", "qy", "qz")}
    columns["t"].view(np.uint64)[20] = 0x7FF4000000000000
    pq.write_table(pa.table({k: pa.array(v, from_pandas=False) for k, v in columns.items()}), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="time is not a number in sample 20") as raised:
        import_log(tmp_path / "a.parquet")
    assert "\n" not in str(raised.value)
