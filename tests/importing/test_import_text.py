"""Tables that are no plain CSV: lists in a cell, a prefix on each line, blanks; and what is not used of a log."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from flights_made import made_flight
from writers_bag import write_bag1

from infotraj.datasets.location import find_dataset, how_to_get
from infotraj.errors import InputError, UsageError
from infotraj.importing import Mapping, import_log, parse_mapping
from infotraj.importing.command import import_command

GOOD = made_flight(2.0)
LISTS: dict[str, Any] = {
    "position": {"fields": ["pos[0]", "pos[1]", "pos[2]"]},
    "rotor_command": {"fields": "motors[*]"},
}


def table_mapping(channels: dict[str, Any], **top: Any) -> Mapping:
    return parse_mapping(
        {"name": "m", "reads": ["table"], "time": {"fields": "t"}, "streams": [{"name": "s", "channels": channels}]}
        | top
    )


def list_columns(write: Any) -> pd.DataFrame:
    rotors = GOOD.numbered("cmd_rotor_")
    return pd.DataFrame(
        {
            "t": GOOD.t,
            "pos": [write(row) for row in GOOD.get("px", "py", "pz")],
            "motors": [write(row) for row in rotors],
        }
    )


@pytest.mark.parametrize(
    "write",
    [
        lambda row: "[" + ", ".join(f"{v:.17g}" for v in row) + "]",
        lambda row: "[" + "  ".join(f"{v:.17g}" for v in row) + "]",
        lambda row: "[ " + "\n ".join(f"{v:.17g}" for v in row) + " ]",
        lambda row: "(" + ", ".join(f"{v:.17g}" for v in row) + ")",
        lambda row: "array([" + ", ".join(f"{v:.17g}" for v in row) + "])",
    ],
    ids=["json", "numpy", "numpy over lines", "tuple", "repr"],
)
def test_list_cells_become_columns(write: Any, tmp_path: Path) -> None:
    list_columns(write).to_csv(tmp_path / "log.csv", index=False, float_format="%.17g")
    found = import_log(tmp_path / "log.csv", table_mapping(LISTS))
    np.testing.assert_array_equal(found.get("px", "py", "pz"), GOOD.get("px", "py", "pz"))
    np.testing.assert_array_equal(found.numbered("cmd_rotor_"), GOOD.numbered("cmd_rotor_"))


def test_list_cells_without_quotes_between_blanks(tmp_path: Path) -> None:
    table = list_columns(lambda row: "[" + " ".join(f"{v:.17g}" for v in row) + "]")
    lines = [",".join(map(str, row)) for row in [tuple(table.columns), *table.itertuples(index=False)]]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    found = import_log(tmp_path / "log.csv", table_mapping(LISTS))
    np.testing.assert_array_equal(found.get("px", "py", "pz"), GOOD.get("px", "py", "pz"))


def test_lists_in_parquet(tmp_path: Path) -> None:
    table = pa.Table.from_pandas(list_columns(list), preserve_index=False)
    pq.write_table(table, tmp_path / "log.parquet")
    found = import_log(tmp_path / "log.parquet", table_mapping(LISTS))
    np.testing.assert_array_equal(found.numbered("cmd_rotor_"), GOOD.numbered("cmd_rotor_"))


def test_an_empty_list_cell_is_no_sample_and_a_short_one_is_named(tmp_path: Path) -> None:
    table = list_columns(lambda row: str(list(map(float, row))))
    table.loc[3, "pos"] = None
    table.to_csv(tmp_path / "log.csv", index=False)
    found = import_log(tmp_path / "log.csv", table_mapping(LISTS))
    assert np.isnan(found.get("px", "py", "pz")[3]).all()
    assert np.isfinite(found.get("px")[4])
    table.loc[5, "pos"] = "[1.0, 2.0]"
    table.to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(InputError, match=r"column 'pos', row 6: '\[1.0, 2.0\]'; expected a list of 3 numbers"):
        import_log(tmp_path / "log.csv", table_mapping(LISTS))


def test_columns_of_blanks(tmp_path: Path) -> None:
    GOOD.table.to_string(tmp_path / "log.txt", index=False, float_format=lambda v: f"{v:.12f}")
    found = import_log(tmp_path / "log.txt")
    assert found.meta["mapping"] == "flight_table"
    np.testing.assert_allclose(found.get("px", "vx", "ax"), GOOD.get("px", "vx", "ax"), atol=1e-11)


def prefixed(rows: pd.DataFrame, prefix: str) -> str:
    text = rows.to_csv(index=False, float_format="%.17g")
    return "".join(f"{prefix % k}{line}\n" for k, line in enumerate(text.splitlines()))


def test_a_prefix_is_taken_off_and_other_lines_are_left_out(tmp_path: Path) -> None:
    text = prefixed(GOOD.table, "[%d] <INFO> log: ").splitlines(keepends=True)
    text.insert(5, "[4] <WARN> a word from elsewhere\n")
    (tmp_path / "log.log").write_text("".join(text))
    layout = {"line_prefix": r"\[\d+\] <INFO> log: "}
    channels = {"position": {"fields": ["px", "py", "pz"]}}
    found = import_log(tmp_path / "log.log", table_mapping(channels, table=layout))
    np.testing.assert_array_equal(found.get("px", "py", "pz"), GOOD.get("px", "py", "pz"))
    assert "1 lines without the line prefix are left out" in found.meta["notes"]


def test_comments_skipped_lines_names_and_decimal_commas_as_declared(tmp_path: Path) -> None:
    rows = "\n".join(
        ";".join(f"{v:.12f}".replace(".", ",") for v in row) for row in GOOD.get("px", "py", "pz", "vx").round(12)
    )
    (tmp_path / "log.txt").write_text(f"some machine\nof 2026\n% no names\n{rows}\n% end\n")
    layout = {"skip": 2, "comment": "%", "separator": ";", "decimal": ",", "header": ["a", "b", "c", "t"]}
    channels: dict[str, dict] = {"position": {"fields": ["a", "b", "c"]}}
    with pytest.raises(InputError, match="time goes back"):  # vx is no time, but it is read as one
        import_log(tmp_path / "log.txt", table_mapping(channels, table=layout))
    rows = "\n".join(f"{k / 100:.2f};{x:.12f}".replace(".", ",") for k, x in enumerate(GOOD.get("px")[:, 0]))
    (tmp_path / "log.txt").write_text(f"some machine\nof 2026\n% no names\n{rows}\n% end\n")
    layout["header"] = ["t", "x"]
    channels = {"position": {"fields": ["x"], "mix": [[1], [0], [0]]}}
    found = import_log(tmp_path / "log.txt", table_mapping(channels, table=layout))
    np.testing.assert_allclose(found.get("px"), GOOD.get("px"), atol=1e-11)
    np.testing.assert_allclose(found.t, GOOD.t, atol=1e-12)


def test_a_cut_line_of_a_prefixed_log(tmp_path: Path) -> None:
    text = prefixed(GOOD.table, "[%d] ")
    (tmp_path / "log.log").write_text(text[:-40])
    mapping = table_mapping({"position": {"fields": ["px", "py", "pz"]}}, table={"line_prefix": r"\[\d+\] "})
    with pytest.raises(InputError, match="the last row has"):
        import_log(tmp_path / "log.log", mapping)
    found = import_log(tmp_path / "log.log", mapping, allow_damaged=True)
    assert len(found.table) == len(GOOD.table) - 1
    half = text.splitlines(keepends=True)
    half[50] = half[50][:60] + "\n"
    (tmp_path / "log.log").write_text("".join(half))
    with pytest.raises(InputError, match="row 50 has"):
        import_log(tmp_path / "log.log", mapping, allow_damaged=True)


def test_a_layout_whose_prefix_is_not_there(tmp_path: Path) -> None:
    GOOD.table.to_csv(tmp_path / "log.csv", index=False)
    mapping = table_mapping({"position": {"fields": ["px", "py", "pz"]}}, table={"line_prefix": "never"})
    with pytest.raises(InputError, match="no line of the layout"):
        import_log(tmp_path / "log.csv", mapping)


@pytest.mark.parametrize("layout", [{"line_prefix": "["}, {"decimal": "x"}, {"separator": ",", "decimal": ","}])
def test_a_wrong_layout_is_one_line(layout: dict[str, Any]) -> None:
    with pytest.raises(UsageError) as error:
        table_mapping({"position": {"fields": ["px", "py", "pz"]}}, table=layout)
    assert "\n" not in str(error.value)


def test_explain_says_what_is_not_used_and_why(tmp_path: Path) -> None:
    table = GOOD.table.drop(columns=["qz"]).assign(note="text", temperature=GOOD.t, flag=3, nothing=np.nan)
    table.to_csv(tmp_path / "log.csv", index=False)
    result = CliRunner().invoke(import_command, [str(tmp_path / "log.csv"), "--explain"])
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert "- qw, qx, qy: for attitude, qz is lacking" in lines
    assert "- temperature: no channel of mapping flight_table asks for it" in lines
    assert "- note: no channel of mapping flight_table asks for it; text" in lines
    assert "- flag: no channel of mapping flight_table asks for it; constant 3" in lines
    assert "- nothing: no channel of mapping flight_table asks for it; empty" in lines
    assert any(line.startswith("- attitude: needed for") and line.endswith("(lacking qz)") for line in lines)
    assert not any(line.startswith("- px") for line in lines)


def test_explain_does_not_say_that_a_mapping_fits_that_finds_no_channel(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,x\n0,1\n1,2\n")
    result = CliRunner().invoke(import_command, [str(tmp_path / "log.csv"), "--explain"])
    assert result.exit_code == 3
    assert "mapping flight_table has what it requires (t), but finds the columns of no channel" in result.stdout
    assert " fits;" not in result.stdout


def test_flights_of_an_octorotor_with_a_loggers_prefix() -> None:
    folder = find_dataset("acsl_x8")
    if folder is None:
        pytest.skip(how_to_get("acsl_x8"))
    rows = {}
    for path in sorted(folder.rglob("*.log")):
        found = import_log(path)
        rows[path.stem] = (found.meta["mapping"], len(found.table))
        if found.meta["mapping"] == "acsl_x8":
            flown = found.between(12.0, 18.0)
            thrust = flown.numbered("cmd_rotor_").sum(axis=1)
            assert flown.numbered("cmd_rotor_").shape[1] == 8
            # the weight is 18.8 N; the loaded flight asks for twice that (NOTES.md)
            assert (40 if "20240729" in path.stem else 18) < np.median(thrust) < (60 if "20240729" in path.stem else 28)
            assert np.median(flown.get("pz")) > 0.1
            # thrust acts along the table's z axis: hardly tilted, that axis points up
            up = 1 - 2 * (flown.get("qx") ** 2 + flown.get("qy") ** 2)
            assert np.median(up) > 0.9
    assert rows == {
        "log_20240613_115633": ("acsl_x8", 3261),
        "log_20240613_121802": ("acsl_x8", 2901),
        "log_20240621_103807": ("acsl_x8", 3318),
        "log_20240729_163817": ("acsl_x8", 2289),
        "mocap_log_20240613_115633": ("acsl_mocap", 3256),
        "mocap_log_20240613_121802": ("acsl_mocap", 2901),
        "mocap_log_20240621_103807": ("acsl_mocap", 3313),
        "mocap_log_20240729_163817": ("acsl_mocap", 2278),
    }


def two_files(folder: Path, zero: float = 0.0) -> tuple[Path, Path]:
    motors = GOOD.table.filter(regex=r"^(t|cmd_rotor_\d)$")
    motors.to_csv(folder / "motors.csv", index=False, float_format="%.17g")
    poses = GOOD.table[["t", "px", "py", "pz", "qw", "qx", "qy", "qz"]].rename(columns={"t": "time"})
    held = poses.loc[poses.index.repeat(3)].reset_index(drop=True)
    held["time"] = np.interp(np.arange(len(held)) / 3, poses.index, poses["time"]) + zero
    held.to_csv(folder / "poses.csv", index=False, float_format="%.17g")
    return folder / "motors.csv", folder / "poses.csv"


TRACKER = {
    "name": "tracker",
    "time": {"fields": "time"},
    "drop_repeats": True,
    "channels": {"position": {"fields": ["px", "py", "pz"]}, "attitude": {"fields": ["qw", "qx", "qy", "qz"]}},
}
MOTORS = {"name": "motors", "channels": {"rotor_command": {"fields": "cmd_rotor_*"}}}
JOINED = {"name": "m", "reads": ["table"], "time": {"fields": "t"}, "streams": [TRACKER, MOTORS]}


def test_two_tables_of_one_flight_and_held_samples(tmp_path: Path) -> None:
    """Poses that a logger wrote three times over, in a file of their own: each counts once, where it was new."""
    motors, poses = two_files(tmp_path)
    found = import_log(motors, parse_mapping(JOINED), beside=(poses,))
    np.testing.assert_allclose(found.t, GOOD.t, atol=1e-12)
    np.testing.assert_array_equal(found.get("px", "qw"), GOOD.get("px", "qw"))
    np.testing.assert_array_equal(found.numbered("cmd_rotor_"), GOOD.numbered("cmd_rotor_"))
    assert [entry["source_file"] for entry in found.meta["with"]] == ["poses.csv"]
    assert "tracker: 400 of 600 samples repeat the one before and are left out" in found.meta["notes"]
    alone = import_log(motors, parse_mapping(JOINED))
    assert "px" not in alone.table


def test_a_table_that_the_mapping_takes_nothing_from_is_not_passed_over(tmp_path: Path) -> None:
    motors, poses = two_files(tmp_path)
    log = tmp_path / "weather.csv"
    pd.DataFrame({"time": [0.0, 1.0], "humidity": [0.4, 0.5]}).to_csv(log, index=False)
    with pytest.raises(InputError, match=r"weather\.csv: m takes no channel from it; it has time, humidity; expected"):
        import_log(motors, parse_mapping(JOINED), beside=(poses, log))


def test_two_tables_whose_clocks_have_nothing_in_common(tmp_path: Path) -> None:
    motors, poses = two_files(tmp_path, zero=100.0)
    with pytest.raises(InputError, match="nothing in common"):
        import_log(motors, parse_mapping(JOINED), beside=(poses,))
    shifted = parse_mapping({**JOINED, "streams": [{**TRACKER, "shift": -100.0}, MOTORS]})
    np.testing.assert_allclose(import_log(motors, shifted, beside=(poses,)).t, GOOD.t, atol=1e-9)


def test_the_motion_capture_beside_a_log_is_the_pose() -> None:
    folder = find_dataset("acsl_x8")
    if folder is None:
        pytest.skip(how_to_get("acsl_x8"))
    log = next(folder.rglob("log_20240621_103807.log"))
    tracker = next(folder.rglob("mocap_log_20240621_103807.log"))
    found = import_log(log, beside=(tracker,), start=12.0, stop=20.0)
    assert found.meta["channels"]["position"]["stream"] == "mocap"
    assert found.meta["channels"]["rotor_command"]["unit"] == "N"
    assert 95 < found.meta["channels"]["position"]["rate_hz"] < 101  # held over 370 Hz in the file


@pytest.mark.parametrize("extra", [["--fix"], ["second.csv"]])
def test_with_is_for_one_log_and_not_beside_fix(extra: list[str], tmp_path: Path) -> None:
    motors, poses = two_files(tmp_path)
    (tmp_path / "second.csv").write_text("t\n0\n1\n")
    more = [str(tmp_path / e) if e.endswith(".csv") else e for e in extra]
    out = ["-o", str(tmp_path / "out" if len(more[0]) > 8 else tmp_path / "out.parquet")]
    result = CliRunner().invoke(import_command, [str(motors), *more, "--with", str(poses), *out])
    assert isinstance(result.exception, UsageError)
    assert not list(tmp_path.glob("out*"))


FROM_ONE = {f"m{k}": GOOD.get(f"cmd_rotor_{k - 1}") for k in range(1, 5)}


@pytest.mark.parametrize(
    ("fields", "note"),
    [
        (["M1", "M2", "M3", "M4"], "no M1, M2, M3, M4; nearest: m1, m2, m3, m4"),
        ("mot*", "no mot*; the log has t, px, py, pz, m1, m2, m3, m4"),
        ("m*", "m* counts from 0, and the log has m1, m2, m3, m4; name them: fields: [m1, m2, m3, m4]"),
        (["m1", "m2", "m3", "m4"], None),
    ],
)
def test_a_channel_of_ones_own_mapping_without_a_column_is_noted(tmp_path: Path, fields: Any, note: str | None) -> None:
    path = tmp_path / "a.csv"
    GOOD.table[["t", "px", "py", "pz"]].assign(**FROM_ONE).to_csv(path, index=False)
    named = {"position": {"fields": ["px", "py", "pz"]}, "rotor_command": {"fields": fields}}
    found = import_log(path, table_mapping(named))
    assert found.numbered("cmd_rotor_").shape[1] == (4 if note is None else 0)
    about = [n for n in found.meta["notes"] if n.startswith("rotor_command")]
    assert about == ([f"rotor_command left out: {note}"] if note is not None else [])


def test_numbers_of_a_flight_table_that_count_from_1_are_noted(tmp_path: Path) -> None:
    """Of all else that a shipped mapping asks for, and no log has in full, nothing is said."""
    columns = {name.replace("m", "cmd_rotor_"): values for name, values in FROM_ONE.items()}
    GOOD.table[["t", "px", "py", "pz"]].assign(**columns).to_csv(tmp_path / "a.csv", index=False)
    notes = import_log(tmp_path / "a.csv").meta["notes"]
    assert [n.split(", and")[0] for n in notes] == ["rotor_command left out: cmd_rotor_* counts from 0"]


def test_a_topic_of_ones_own_mapping_that_the_bag_lacks_is_noted(tmp_path: Path) -> None:
    content = {
        "name": "mine",
        "reads": ["rosbag"],
        "streams": [
            {"name": "i", "topic": "/hummingbird/imu", "channels": {"rate": {"fields": of("angular_velocity")}}},
            {"name": "p", "topic": "/hummingbird/odom", "channels": {"position": {"fields": of("pose.pose.position")}}},
        ],
    }
    notes = import_log(write_bag1(GOOD, tmp_path / "a.bag"), parse_mapping(content)).meta["notes"]
    assert [n for n in notes if "left out" in n] == [
        "position left out: no topic /hummingbird/odom; nearest: /hummingbird/odometry"
    ]


def of(name: str) -> list[str]:
    return [f"{name}.{axis}" for axis in "xyz"]


def _decimal_commas(text: str) -> bytes:
    return text.replace(",", ";").replace(".", ",").encode()


def _dates(text: str) -> bytes:
    head, *rows = text.splitlines()
    return "\n".join([head, *(f"2026-01-02T10:00:00.{r[:1]}{r[r.index(',') :]}" for r in rows)]).encode()


def _units(text: str) -> bytes:
    head, rows = text.split("\n", 1)
    return f"{head}\n{','.join('m' for _ in head.split(','))}\n{rows}".encode()


@pytest.mark.parametrize(
    ("change", "found", "remedy"),
    [
        (_decimal_commas, "column 'px', row 1", 'table: {decimal: ","}'),
        (_units, "column 'px', row 1: 'm'", "table: {skip: 2, header: [t,px,py,pz,qw,qx,qy,qz]}"),
        (
            lambda text: b"# a log, by me\n# second\n" + text.encode(),
            "first line is '# a log, by me'",
            'table: {comment: "#"}',
        ),
        (lambda text: b"A log\n" + text.encode(), "first line is 'A log'", "table: {skip: 1}"),
        (_dates, "row 1: '2026-01-02T10:00:00", None),
        (lambda text: text.encode("utf-16"), "holds text in UTF-16", None),
        (lambda text: text.replace("qz", "qz [\u00b0]").encode("latin-1"), "iconv -f ISO-8859-1 -t UTF-8", None),
        (lambda text: gzip.compress(text.encode()), "holds gzip data; expected", None),
    ],
    ids=["decimal comma", "units", "comment", "title", "dates", "utf-16", "latin-1", "gzip"],
)
def test_a_text_that_is_laid_out_otherwise_is_told_what_reads_it(
    change: Any, found: str, remedy: str | None, tmp_path: Path
) -> None:
    text = GOOD.table[["t", "px", "py", "pz", "qw", "qx", "qy", "qz"]].to_csv(index=False)
    path = tmp_path / "log.csv"
    path.write_bytes(change(text))
    with pytest.raises(InputError) as caught:
        import_log(path)
    assert found in str(caught.value)
    if remedy is None:
        return
    said = remedy.replace("[t,px,py,pz,qw,qx,qy,qz]", "[t, px, ..]")
    assert f"`{said}`" in str(caught.value)
    (tmp_path / "m.yaml").write_text(f"extends: flight_table\n{remedy}\n")
    np.testing.assert_allclose(import_log(path, tmp_path / "m.yaml").get("px", "qw"), GOOD.get("px", "qw"))
