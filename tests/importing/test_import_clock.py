"""Streams without stamps go by the recording times, also where the two clocks run at different speeds."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from flights_made import made_flight
from writers_bag import EPOCH_NS, write_bag1

from infotraj.checking import check
from infotraj.errors import InputError
from infotraj.flight import Flight
from infotraj.importing import import_log
from infotraj.importing.clock import Ticks, align, late, stamped, tidy, within


@pytest.mark.parametrize("speed", [0.98, 1.0, 1.02])
def test_a_stream_without_stamps_is_put_on_the_clock_of_one_that_has_them(speed: float) -> None:
    record = 5_000_000_000 + 10_000_000 * np.arange(1001, dtype=np.int64)
    stamp = (7_000_000 + speed * (record - record[0])).astype(np.int64)
    rows, other = Ticks(stamp, "header.stamp", record), Ticks(record[::50], "record", record[::50])
    notes: list[str] = []
    align(rows, {"motors": other}, notes)
    np.testing.assert_allclose(other.values, stamp[::50], atol=10)  # ns
    assert "motors: it has no stamps" in notes[0]


def test_stamps_that_are_late_by_the_times_of_recording_are_told() -> None:
    record = 10**9 * np.arange(20, dtype=np.int64)
    rows = Ticks(record - 8_000_000, "header.stamp", record)
    assert late(rows, Ticks(record + 3_698_000_000, "header.stamp", record)) == pytest.approx(3.706)
    assert late(rows, Ticks(2 * record, "header.stamp", record)) == 0.0
    assert late(rows, Ticks(record, "record", record)) == 0.0


EVEN = np.round(5.0 + 0.01 * np.arange(400), 6)
FORWARD = np.append(EVEN, EVEN + 7204.0)
SET_BACK = np.append(EVEN, EVEN - 4.0)
LATE = np.sort(EVEN)[np.argsort(np.arange(400) + 30.0 * (np.arange(400) % 50 == 7), kind="stable")]


def _cut(t: np.ndarray, start: float | None, stop: float | None, may_reorder: bool = True) -> np.ndarray:
    kept = t[within(t, start, stop, may_reorder)]
    order = tidy(kept, "topic", Path("log"), may_reorder, [])
    return kept[order][(kept[order] >= (start or -np.inf)) & (kept[order] < (stop or np.inf))]


@pytest.mark.parametrize("may_reorder", [True, False])
@pytest.mark.parametrize(
    ("t", "start", "stop", "wanted"),
    [
        (FORWARD, None, 8.995, FORWARD[:400]),
        (FORWARD, None, 20.0, FORWARD[:400]),
        (FORWARD, 6.0, 20.0, FORWARD[100:400]),
        (FORWARD, 20.0, None, FORWARD[400:]),
        (FORWARD, 7210.0, None, FORWARD[500:]),
        (SET_BACK, None, 9.0, SET_BACK[:400]),
        (SET_BACK, None, 5.0, SET_BACK[400:]),
        (SET_BACK, 1.5, 4.0, SET_BACK[450:700]),
        (np.append(np.nan, EVEN), 6.0, 7.0, EVEN[100:200]),
    ],
)
def test_a_cut_leaves_out_what_lies_beyond_a_break_of_the_clock(
    t: np.ndarray, start: float | None, stop: float | None, wanted: np.ndarray, may_reorder: bool
) -> None:
    np.testing.assert_array_equal(_cut(t, start, stop, may_reorder), wanted)


@pytest.mark.parametrize("t", [FORWARD, SET_BACK, FORWARD + 0.0123456])
def test_the_times_that_a_broken_clock_is_to_be_cut_at_work(t: np.ndarray) -> None:
    with pytest.raises(InputError) as error:
        _cut(t, None, None)
    said = dict(re.findall(r"--(to|from) (\d+(?:\.\d+)?)", str(error.value)))
    np.testing.assert_array_equal(_cut(t, None, float(said["to"])), t[:400])
    if "from" in said:
        np.testing.assert_array_equal(_cut(t, float(said["from"]), None)[-399:], t[401:])


@pytest.mark.parametrize("t", [FORWARD, np.append(EVEN, EVEN - 2.0), LATE])
def test_a_break_inside_the_cut_still_rejects(t: np.ndarray) -> None:
    with pytest.raises(InputError):
        _cut(t, 6.0, 8.5 if t is LATE else 10_000.0)


def test_a_value_from_before_the_cut_is_kept_to_be_held() -> None:
    np.testing.assert_array_equal(within(np.array([4.9]), 7.0, 9.0, True), [0])
    np.testing.assert_array_equal(within(np.array([4.9, 6.0, 12.0]), 7.0, 9.0, True), [1, 2])


def test_a_stamp_of_0_among_others_is_none() -> None:
    record = 1_700_000_000_000_000_000 + 10_000_000 * np.arange(6, dtype=np.int64)
    unset = np.array([True, False, False, True, False, False])
    for begin in (record[0], 5_000_000_000):  # of the day, and of a clock since boot
        stamps = np.where(unset, 0, begin + record - record[0])
        found = stamped(Ticks(stamps, "header.stamp", record))
        np.testing.assert_array_equal(found, ~unset if begin == record[0] else ~unset | (np.arange(6) == 0))
    simulated = 10_000_000 * np.arange(6, dtype=np.int64)
    assert stamped(Ticks(simulated, "header.stamp", record)).all()
    assert stamped(Ticks(simulated / 1e9, "t")).all()


def test_a_bag_with_unset_stamps_comes_back_without_their_messages(tmp_path: Path) -> None:
    flight = made_flight(2.0)
    log = write_bag1(flight, tmp_path / "a.bag", stamped=lambda t: t if t > 0.0 else -EPOCH_NS / 1e9)
    found = import_log(log, start=0.5)
    assert any("messages with the stamp 0 are left out" in note for note in found.meta["notes"])
    assert found.t[0] == pytest.approx(0.5, abs=0.02)
    assert len(found.t) == pytest.approx(150, abs=2)


def test_slow_rows_of_a_log_whose_imu_and_commands_are_faster_are_told(tmp_path: Path) -> None:
    made = made_flight(4.0)
    table = made.table.copy()
    table.loc[table.index % 4 != 0, ["px", "py", "pz"]] = np.nan
    log = write_bag1(Flight(table), tmp_path / "a.bag")
    slow, fast = import_log(log), import_log(log, rows="rate")
    assert len(slow.t) == len(made.t) // 4
    said = "a row every 40 ms, where the log has rate every 10 ms, specific_force every 10 ms"
    assert [said in note and "--rows rate" in note for note in slow.meta["notes"]] == [True]
    (found,) = [f for f in check(slow) if f.code == "slow_rows"]
    assert said in found.what
    assert "--rows rate" in found.remedy
    assert not fast.meta["notes"]
    assert "slow_rows" not in [f.code for f in check(fast)]


@pytest.mark.parametrize("unit", ["us", "ns"])
def test_a_column_of_whole_times_since_1970_in_a_finer_unit_is_said_to_be_one(tmp_path: Path, unit: str) -> None:
    table = made_flight(1.0).table
    per_s = {"us": 10**6, "ns": 10**9}[unit]
    table["t"] = 1_764_300_000 * per_s + np.round(table["t"] * per_s).astype(np.int64)
    table.to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(InputError, match=rf"rows are 1e\+0[47] s apart; .*--set time\.unit={unit}"):
        import_log(tmp_path / "a.csv")
    assert import_log(tmp_path / "a.csv", settings={"time": {"unit": unit}}).t[-1] == pytest.approx(0.99)


def test_commands_that_come_rarely_are_said_to_be_held_over_the_rows(tmp_path: Path) -> None:
    table = made_flight(2.0).table.copy()
    table.loc[table.index % 5 != 0, [c for c in table if c.startswith("cmd_rotor_")]] = np.nan
    found = import_log(write_bag1(Flight(table), tmp_path / "a.bag"))
    assert "rotor_command comes every 50 ms only, and is held over the rows between" in found.meta["notes"]
    assert import_log(write_bag1(made_flight(2.0), tmp_path / "b.bag")).meta["notes"] == []
