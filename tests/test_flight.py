"""The flight table: nothing is lost on the way to a file and back, and bad tables are named in one line."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from infotraj.errors import InputError
from infotraj.flight import POSITION, Flight, check_table, read_flight, sha256

cells = st.one_of(st.floats(-1e9, 1e9, allow_subnormal=False), st.just(np.nan))


def table(n: int = 5) -> pd.DataFrame:
    t = 0.01 * np.arange(n)
    return pd.DataFrame({"t": t, "px": np.sin(t), "py": t**2, "pz": 1.0 + t, "rotor_0": 600.0 + t, "rotor_1": 500.0})


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None)
@given(values=arrays(float, (6, 2), elements=cells))
def test_a_flight_comes_back_as_it_was_written(tmp_path, suffix, values):
    frame = pd.DataFrame({"t": np.cumsum([0.1] * 6), "px": values[:, 0], "battery": values[:, 1]})
    path = tmp_path / f"flight{suffix}"
    Flight(frame, {"mapping": "omav", "derived": ["vx"]}).write(path)
    back = read_flight(path)
    pd.testing.assert_frame_equal(back.table, frame, check_exact=True, check_dtype=False)
    assert back.meta == {"mapping": "omav", "derived": ["vx"], "source": str(path)}


def test_a_table_does_not_take_over_what_was_said_of_the_one_before_it(tmp_path):
    frame, path = table(), tmp_path / "flight.csv"
    Flight(frame, {"accepted": ["jitter"]}).write(path)
    Flight(frame).write(path)
    assert read_flight(path).meta == {"source": str(path)}


def test_measured_numbers_survive_a_csv_to_the_last_bit(tmp_path):
    values = np.random.default_rng(0).normal(size=2000)
    Flight(pd.DataFrame({"t": np.arange(2000.0), "px": values})).write(tmp_path / "a.csv")
    assert np.array_equal(read_flight(tmp_path / "a.csv").table["px"], values)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_only_whole_files_are_left(tmp_path, suffix):
    Flight(table()).write(tmp_path / f"a{suffix}")
    assert [p.name for p in tmp_path.iterdir()] == [f"a{suffix}"]


def test_a_failed_write_leaves_nothing_and_keeps_the_old_file(tmp_path):
    path = tmp_path / "a.parquet"
    Flight(table()).write(path)
    before = sha256(path)
    broken = Flight(table(), {"when": object()})
    with pytest.raises(TypeError):
        broken.write(path)
    assert [p.name for p in tmp_path.iterdir()] == ["a.parquet"]
    assert sha256(path) == before


def test_an_unknown_ending_is_refused_on_both_sides(tmp_path):
    with pytest.raises(InputError, match=r"\.parquet or \.csv"):
        Flight(table()).write(tmp_path / "a.xlsx")
    (tmp_path / "a.xlsx").write_text("t\n")
    with pytest.raises(InputError, match=r"ends in '\.xlsx'"):
        read_flight(tmp_path / "a.xlsx")
    assert [p.name for p in tmp_path.iterdir()] == ["a.xlsx"]


def test_columns_are_found_by_name_and_number():
    flight = Flight(table().assign(battery=np.nan))
    assert flight.get(*POSITION).shape == (5, 3)
    assert np.array_equal(flight.numbered("rotor_")[:, 1], np.full(5, 500.0))
    assert flight.numbered("tilt_").shape == (5, 0)
    assert flight.has("px", "rotor_0")
    assert not flight.has("px", "battery"), "a column of empty cells holds nothing"
    with pytest.raises(InputError, match="columns vx, vy are missing; expected"):
        flight.get("px", "vx", "vy")


def test_between_takes_the_first_row_and_leaves_the_last():
    part = Flight(table()).between(0.01, 0.03)
    assert part.t.tolist() == [0.01, 0.02]
    assert part.table.index.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: f.drop(columns="t"), "no column t among px"),
        (lambda f: f.head(1), "1 rows; expected at least 2"),
        (lambda f: f.assign(t=[0.0, 0.1, 0.1, 0.2, 0.3]), "time goes from 0.100000 to 0.100000 s at row 2"),
        (lambda f: f.assign(t=[0.0, 0.2, 0.1, 0.3, 0.4]), "time goes from 0.200000 to 0.100000 s at row 2"),
        (lambda f: f.assign(t=[0.0, 0.1, np.nan, 0.3, 0.4]), "t is not a number in row 2"),
        (lambda f: f.assign(t=[0.0, 0.1, 0.2, 0.3, np.inf]), "t is not a number in row 4"),
        (lambda f: f.assign(px=["a"] * 5), "column px holds text"),
    ],
)
def test_a_bad_table_is_named_in_one_line(change, says):
    with pytest.raises(InputError, match=says) as caught:
        check_table(change(table()), source="log.csv")
    assert str(caught.value).startswith("log.csv: ")
    assert "\n" not in str(caught.value)


def test_a_csv_whose_last_row_was_cut_is_one_line_that_says_what_to_do(tmp_path):
    path = tmp_path / "a.csv"
    Flight(pd.DataFrame({"t": np.arange(50.0), "px": 0.5, "py": 0.25})).write(path)
    whole = path.read_text()
    path.write_text(whole[: whole.rstrip().rindex(",")])
    with pytest.raises(InputError, match=r"the last row has 2 fields; expected 3.*--allow-damaged") as caught:
        read_flight(path)
    assert "\n" not in str(caught.value)
    path.write_text(whole.replace("\n7,0.5,0.25", "\n7,0.5"))
    with pytest.raises(InputError, match="row 8 has 2 fields; expected 3"):
        read_flight(path)
    path.write_text(whole + "\n")
    assert len(read_flight(path).t) == 50


@pytest.mark.parametrize("name", ["empty.csv", "empty.parquet", "noise.csv", "noise.parquet", "cut.parquet"])
def test_a_broken_file_is_one_line(tmp_path, name):
    path = tmp_path / name
    if name == "cut.parquet":
        Flight(table(200)).write(path)
        path.write_bytes(path.read_bytes()[:-20])
    else:
        path.write_bytes(b"" if "empty" in name else bytes(range(128, 256)) * 20)
    with pytest.raises(InputError) as caught:
        read_flight(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_path_without_a_file_says_which(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_flight(tmp_path / "a.csv")
    with pytest.raises(InputError, match="a folder"):
        read_flight(tmp_path)
