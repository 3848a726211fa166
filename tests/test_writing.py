"""Files are written whole or not at all, by several runs at once too."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pandas as pd
import pytest

from infotraj.errors import InfotrajError
from infotraj.flight import Flight
from infotraj.outputs import require_outputs
from infotraj.writing import whole


def test_two_that_write_one_file_at_once_do_not_meet(tmp_path):
    path = tmp_path / "new" / "a.json"
    with whole(path) as first, whole(path) as second:
        first.write_text("first")
        second.write_text("second")
    assert path.read_text() == "first"  # of both the one that ended last
    assert list(tmp_path.rglob("*.part")) == []


def test_what_fails_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("before")

    def half() -> None:
        with whole(path) as part:
            part.write_text("half")
            raise OSError("the disk is full")

    with pytest.raises(InfotrajError, match="disk is full"):
        half()
    assert {p: p.read_text() for p in tmp_path.iterdir()} == {path: "before"}


@pytest.mark.parametrize("name", ["f.csv", "f.parquet"])
def test_a_flight_that_cannot_be_written_is_one_line_and_nothing_is_there(name, tmp_path):
    flight = Flight(pd.DataFrame({"t": [0.0, 0.1]}), {"source": "log"})
    (tmp_path / name).mkdir()
    with pytest.raises(InfotrajError, match="expected a place that can be written"):
        flight.write(tmp_path / name)
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []


def test_runs_that_try_and_write_at_once_take_nothing_from_each_other(tmp_path):
    def tried(folder: Path) -> None:
        require_outputs({"--json": folder / "deep" / "a.json"}, {"--figures": folder / "figures"}, {})

    def written(folder: Path) -> None:
        with whole(folder / "deep" / "a.json") as part:
            part.write_text("written")

    with ThreadPoolExecutor(6) as runs:
        for k in range(100):
            folder = tmp_path / f"new{k}"
            begun = [runs.submit(do, folder) for do in (tried, written, tried, written, tried, tried)]
            for one in begun:
                one.result()
            assert [p.name for p in folder.rglob("*")] == ["deep", "a.json"]
