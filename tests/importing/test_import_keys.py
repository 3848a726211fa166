"""What a mapping's keys do to a channel, in which order, and what they refuse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from flights_made import made_flight
from writers_ulog import write_ulog

from infotraj import rotations
from infotraj.errors import InfotrajError, InputError, UsageError
from infotraj.flight import Flight
from infotraj.importing import Mapping, import_log, load_mapping, parse_mapping, read_streams, shipped

GOOD = made_flight(3.0)
STAND = {"fields": ["px", "py", "pz"]}


def table_mapping(channels: dict[str, Any], stream: dict[str, Any] | None = None, **top: Any) -> Mapping:
    return parse_mapping(
        {
            "name": "m",
            "reads": ["table"],
            "time": {"fields": "t"},
            "streams": [{"name": "s", "channels": channels, **(stream or {})}],
            **top,
        }
    )


def imported(folder: Path, columns: dict[str, Any], channels: dict[str, Any], **top: Any) -> Flight:
    pd.DataFrame(columns).to_csv(folder / "log.csv", index=False, float_format="%.17g")
    return import_log(folder / "log.csv", table_mapping(channels, **top))


def test_values_pass_the_keys_in_the_order_of_the_docs(tmp_path: Path) -> None:
    columns = {"t": [0.0, 0.1], "a": [1000.0, 1000.0], "b": [-3000.0, -3000.0], "c": [7.0, 7.0]}
    keys = {"fields": ["a", "b", "c"], "unit": "rpm", "pick": [1, 0], "mix": [[1, 0.5], [0, 2]], "absolute": True}
    found = imported(tmp_path, columns, {"rotor_command": {**keys, "scale": 2.0, "offset": -1.0, "clip": [0, 450]}})
    rad = 2 * np.pi / 60
    # picked (-3000, 1000) rpm; mixed (-2500, 2000); without sign; doubled; less one; limited
    np.testing.assert_allclose(found.table["cmd_rotor_0"], 450.0)
    np.testing.assert_allclose(found.table["cmd_rotor_1"], 2000 * rad * 2 - 1)
    said = found.meta["channels"]["rotor_command"]
    assert (said["pick"], said["mix"], said["absolute"]) == ([1, 0], [[1.0, 0.5], [0.0, 2.0]], True)


def test_axes_come_after_the_frame_and_may_mirror(tmp_path: Path) -> None:
    columns = {"t": [0.0, 0.1], "p": [1.0, 1.0], "q": [2.0, 2.0], "r": [3.0, 3.0]}
    rate = {"fields": ["p", "q", "r"], "body": "FRD", "axes": ["y", "x", "z"]}
    found = imported(tmp_path, columns, {"rate": rate})
    # FRD to the table gives (1, -2, -3); of that y, x, z
    np.testing.assert_array_equal(found.get("wx", "wy", "wz")[0], [-2.0, 1.0, -3.0])


def test_frames_of_one_channel_leave_the_others(tmp_path: Path) -> None:
    table = GOOD.table.assign(px=GOOD.table["py"], py=GOOD.table["px"], pz=-GOOD.table["pz"])
    velocity = {"fields": ["vx", "vy", "vz"]}
    found = imported(tmp_path, dict(table), {"position": {**STAND, "world": "NED"}, "velocity": velocity})
    np.testing.assert_allclose(found.get("px", "py", "pz"), GOOD.get("px", "py", "pz"))
    np.testing.assert_allclose(found.get("vx", "vy", "vz"), GOOD.get("vx", "vy", "vz"))


def test_a_mix_of_weight_zero_does_not_ask_the_field(tmp_path: Path) -> None:
    columns = {"t": [0.0, 0.1], "thrust": [3.0, 4.0], "lost": [np.nan, np.nan]}
    force = {"fields": ["thrust", "lost"], "mix": [[0, 0], [0, 0], [1, 0]]}
    found = imported(tmp_path, columns, {"commanded_force": force})
    np.testing.assert_array_equal(found.get("cmd_fx", "cmd_fy", "cmd_fz"), [[0, 0, 3], [0, 0, 4]])


def test_a_pitch_of_the_other_sign(tmp_path: Path) -> None:
    roll, pitch, yaw = rotations.to_euler(GOOD.get("qw", "qx", "qy", "qz")).T
    columns = {"t": GOOD.t, "r": np.degrees(roll), "p": -np.degrees(pitch), "y": np.degrees(yaw)}
    keys = {"fields": ["r", "p", "y"], "euler": True, "unit": "deg", "mix": [[1, 0, 0], [0, -1, 0], [0, 0, 1]]}
    found = imported(tmp_path, columns, {"attitude": keys})
    angle = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), GOOD.get("qw", "qx", "qy", "qz"))
    assert angle.max() < 1e-7


@pytest.mark.parametrize("signs", [[-1, 1, 1], [1, -1, 1], [1, 1, -1]])
def test_an_angle_of_the_other_sign_in_a_quaternion(signs: list[int], tmp_path: Path) -> None:
    """Of any length, which stays, and where a row holds none."""
    q = GOOD.get("qw", "qx", "qy", "qz")
    turned = 0.999 * rotations.from_euler(*(rotations.to_euler(q) * signs).T)
    turned[5] = 0.0
    columns = {"t": GOOD.t, **{f"q{k}": turned[:, k] for k in range(4)}}
    attitude = {"fields": ["q0", "q1", "q2", "q3"], "angle_signs": signs}
    found = imported(tmp_path, columns, {"attitude": attitude})
    assert found.meta["channels"]["attitude"]["angle_signs"] == signs
    good = np.arange(len(q)) != 5
    np.testing.assert_allclose(found.get("qw", "qx", "qy", "qz")[good], 0.999 * q[good], atol=1e-12)


def test_a_shifted_channel_is_sampled_on_its_own_times(tmp_path: Path) -> None:
    """A velocity that was stamped 30 ms late agrees with the position again, interpolated, once it is shifted back."""
    late = {name: np.interp(GOOD.t - 0.033, GOOD.t, GOOD.table[name]) for name in ("vx", "vy", "vz")}
    columns = {**{n: GOOD.table[n] for n in ("t", "px", "py", "pz")}, **late}
    velocity = {"fields": ["vx", "vy", "vz"], "shift": -0.033}
    found = imported(tmp_path, columns, {"position": STAND, "velocity": velocity})
    inside = slice(5, -10)
    np.testing.assert_array_equal(found.get("px", "py", "pz"), GOOD.get("px", "py", "pz"))
    error = np.abs(found.get("vx", "vy", "vz") - GOOD.get("vx", "vy", "vz"))[inside].max()
    left = np.abs(np.stack(list(late.values()), axis=-1) - GOOD.get("vx", "vy", "vz"))[inside].max()
    assert error < 2e-4 < 0.02 < left
    assert np.isnan(found.get("vx")[-3:]).all()  # nothing was sampled there
    assert found.meta["channels"]["velocity"]["shift_s"] == -0.033
    assert "shift_s" not in found.meta["channels"]["position"]


def test_a_shift_of_the_stream_moves_all_of_it(tmp_path: Path) -> None:
    GOOD.table.to_csv(tmp_path / "log.csv", index=False, float_format="%.17g")
    plain = read_streams(tmp_path / "log.csv", table_mapping({"position": STAND}))
    moved = read_streams(tmp_path / "log.csv", table_mapping({"position": STAND}, {"shift": 0.25}))
    np.testing.assert_allclose(moved.streams["s"].t, plain.streams["s"].t + 0.25)


def test_a_numbered_field_can_fill_a_vector_by_pick(tmp_path: Path) -> None:
    columns = {"t": [0.0, 0.1], **{f"v{k}": [float(k)] * 2 for k in range(6)}}
    found = imported(tmp_path, columns, {"rate": {"fields": "v*", "pick": [3, 5, 4]}})
    np.testing.assert_array_equal(found.get("wx", "wy", "wz")[0], [3, 5, 4])


@pytest.mark.parametrize(
    ("channel", "keys", "said"),
    [
        ("rate", {"fields": ["a", "b", "c"], "axes": ["x", "x", "z"]}, "not three axes"),
        ("rate", {"fields": ["a", "b", "c"], "body": ["x", "-y", "z"]}, "right-handed"),
        ("rate", {"fields": ["a", "b", "c"], "mix": [[1, 0], [0, 1], [1, 1]]}, "2 weights a list for 3 fields"),
        ("rate", {"fields": ["a", "b", "c"], "mix": [[1, 0, 0]]}, "1 fields, expected 3"),
        ("rate", {"fields": ["a", "b", "c"], "mix": [[1, 0, 0], [1], [1]]}, "differ in length"),
        ("rate", {"fields": ["a", "b", "c"], "pick": [0, 1, 3]}, "pick 3, but there are 3 fields"),
        ("rate", {"fields": ["a", "b", "c"], "absolute": True}, "rotors and tilts only"),
        ("rate", {"fields": "a*"}, "needs `pick` or `mix`"),
        ("rate", {"fields": ["a", "b", "c"], "shift": float("nan")}, "finite number"),
        ("attitude", {"fields": ["a", "b", "c", "d"], "axes": ["x", "-y", "-z"]}, "`world` and `body`"),
        ("rate", {"fields": ["a", "b", "c"], "angle_signs": [1, -1, 1]}, "attitudes only"),
        ("attitude", {"fields": ["a", "b", "c", "d"], "angle_signs": [1, 2, 1]}, "1 or -1"),
        ("battery", {"fields": ["a"], "world": "NED"}, "has no axes"),
        ("battery", {"fields": ["a"], "clip": [2, 1]}, "the first is to be below the second"),
    ],
)
def test_keys_that_do_not_fit_are_one_line(channel: str, keys: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match="(?s)" + said.replace("`", ".")) as error:
        table_mapping({channel: keys})
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("keys", [{"pick": [0, 4]}, {"mix": [[1, 1]]}])
def test_fewer_fields_in_the_log_than_the_mapping_counts_on(keys: dict[str, Any], tmp_path: Path) -> None:
    columns = {"t": [0.0, 0.1], "m0": [1.0, 1.0], "m1": [1.0, 1.0], "m2": [1.0, 1.0]}
    with pytest.raises(InputError, match=r"the log has 3 of m\*"):
        imported(tmp_path, columns, {"rotor_command": {"fields": "m*", **keys}})


def test_extends_takes_over_what_the_file_does_not_say(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text(
        yaml.safe_dump(table_mapping({"position": STAND}, name="base").model_dump(mode="json", exclude_defaults=True))
    )
    stream = {"name": "mine", "channels": {"rate": {"fields": ["p", "q", "r"]}}}
    mine = {"extends": "base.yaml", "world": "NED", "streams": [stream], "set": {"position": {"unit": "mm"}}}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(mine))
    found = load_mapping(tmp_path / "mine.yaml")
    assert (found.name, found.world, [s.name for s in found.streams]) == ("base", "NED", ["mine", "s"])
    assert found.streams[1].channels["position"].unit == "mm"
    (tmp_path / "again.yaml").write_text(yaml.safe_dump({"extends": "mine.yaml", "set": {"rate": {"unit": "deg/s"}}}))
    again = load_mapping(tmp_path / "again.yaml")
    assert again.set == {"position": {"unit": "mm"}, "rate": {"unit": "deg/s"}}
    assert again.streams[1].channels["position"].unit == "mm"


def test_a_shipped_mapping_can_be_extended() -> None:
    found = parse_mapping({"extends": "px4_ulog", "set": {"rate": {"shift": 0.01}}})
    carrying = [s for s in found.streams if "rate" in s.channels]
    assert len(carrying) == 4
    assert all(s.channels["rate"].shift == 0.01 for s in carrying)
    assert all(s.channels["rate"].shift == 0.0 for s in shipped()["px4_ulog"].streams if "rate" in s.channels)


@pytest.mark.parametrize(
    "content",
    [
        {"extends": "no_such"},
        {"extends": 3},
        {"extends": "ros", "set": {"rate": {"unit": "furlong"}}},
        {"extends": "ros", "set": {"rate": {"unti": "deg/s"}}},
        {"extends": "ros", "set": {"rat": {"unit": "deg/s"}}},
        {"extends": "ros", "set": {"battery": {"unit": "V"}, "airborne": {"scale": 2}}},
        {"extends": "ros", "set": 3},
        {"extends": "ros", "streams": 3},
        {"extends": "ros", "requires": {"types": ["("]}},
        {"extends": "flight_table", "table": {"line_prefix": "("}},
        {"extends": "flight_table", "table": {"separator": "::"}},
    ],
)
def test_a_wrong_extension_is_one_line(content: dict[str, Any]) -> None:
    with pytest.raises(InfotrajError) as error:
        parse_mapping(content)
    assert "\n" not in str(error.value)


def test_files_that_extend_each_other_come_to_an_end(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("extends: b.yaml\n")
    (tmp_path / "b.yaml").write_text("extends: a.yaml\n")
    with pytest.raises(UsageError, match="extend one another"):
        load_mapping(tmp_path / "a.yaml")


def test_a_silent_stream_hands_the_channel_on(tmp_path: Path) -> None:
    """A tracker that sends no attitude logs zeros: the angles of another stream are taken, and it is said."""
    roll, pitch, yaw = rotations.to_euler(GOOD.get("qw", "qx", "qy", "qz")).T
    columns = dict(GOOD.table[["t", "px", "py", "pz"]]) | {"r": roll, "p": pitch, "y": yaw, "zero": 0.0 * roll}
    streams = [
        {"name": "tracker", "channels": {"position": STAND, "attitude": {"fields": ["zero"] * 4}}},
        {"name": "estimate", "channels": {"attitude": {"fields": ["r", "p", "y"], "euler": True}}},
    ]
    found = imported(tmp_path, columns, {}, streams=streams)
    assert found.meta["channels"]["attitude"]["stream"] == "estimate"
    assert any("holds only zeros" in note for note in found.meta["notes"])
    angle = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), GOOD.get("qw", "qx", "qy", "qz"))
    assert angle.max() < 1e-7


def test_a_silent_instance_of_a_topic_gives_way_to_the_next(tmp_path: Path) -> None:
    throttle = {c: GOOD.table[c] / 1000.0 for c in GOOD.table if c.startswith("cmd_rotor_")}
    dead = Flight(GOOD.table.assign(battery=0.0, **throttle), {})
    found = import_log(write_ulog(dead, tmp_path / "log.ulg"))
    np.testing.assert_array_equal(found.table["battery"].dropna(), 5.0)  # what the second instance holds
    assert found.meta["channels"]["battery"]["instance"] == 1
    assert "battery: battery (battery_status) holds only zeros" in " ".join(found.meta["notes"])


def test_a_stream_that_is_silent_everywhere_stays_the_first(tmp_path: Path) -> None:
    columns = {"t": GOOD.t, "m0": 0.0 * GOOD.t, "n0": 0.0 * GOOD.t, **GOOD.table[["px", "py", "pz"]]}
    streams = [
        {"name": "first", "channels": {"position": STAND, "rotor_command": {"fields": "m*"}}},
        {"name": "second", "channels": {"rotor_command": {"fields": "n*"}}},
    ]
    found = imported(tmp_path, columns, {}, streams=streams)
    assert found.meta["channels"]["rotor_command"]["stream"] == "first"
    np.testing.assert_array_equal(found.get("cmd_rotor_0"), 0.0)


def test_an_endless_quaternion_is_refused_also_where_frames_are_turned(tmp_path: Path) -> None:
    table = GOOD.table[["t", "qw", "qx", "qy", "qz"]].copy()
    table.loc[7, "qx"] = np.inf
    attitude = {"fields": ["qw", "qx", "qy", "qz"]}
    with pytest.raises(InputError, match=r"is inf at t = 0\.07"):
        imported(tmp_path, dict(table), {"attitude": attitude}, world="NED", body="FRD")


def test_a_table_has_no_time_of_recording(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no time column"):
        imported(tmp_path, dict(GOOD.table), {"position": STAND}, time={"fields": "record"})
