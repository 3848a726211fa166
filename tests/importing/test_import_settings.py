"""`--set` on import and check, on logs and on flight tables; and `--fix`, which sets what check says."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from flights_made import made_flight
from writers_table import NED_MAPPING, write_ned_csv

from infotraj import rotations
from infotraj.checking import Finding
from infotraj.checking.command import check_command
from infotraj.checking.standing import standing
from infotraj.errors import UsageError
from infotraj.flight import Flight, read_flight
from infotraj.importing import (
    Settings,
    import_log,
    load_mapping,
    parse_mapping,
    parse_settings,
    read_streams,
    shipped,
)
from infotraj.importing.channels import CHANNELS
from infotraj.importing.command import import_command
from infotraj.importing.fixing import fix
from infotraj.importing.on_top import on_top
from infotraj.importing.settings import settings_text, with_settings

GOOD = made_flight(6.0)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    GOOD.write(tmp_path / "flight.parquet")
    return tmp_path / "flight.parquet"


def test_settings_are_yaml_and_read_back() -> None:
    texts = ["rate.unit=deg/s", "rate.axes=[x, -y, -z]", "specific_force.shift=-5e-3", "rotor.absolute=true"]
    found = parse_settings(texts)
    mapping = with_settings(shipped()["flight_table"], found)
    channels = mapping.streams[0].channels
    assert (channels["rate"].unit, channels["rate"].axes) == ("deg/s", ("x", "-y", "-z"))
    assert (channels["specific_force"].shift, channels["rotor"].absolute) == (-0.005, True)
    assert with_settings(shipped()["flight_table"], parse_settings(settings_text(found))) == mapping
    assert shipped()["flight_table"].streams[0].channels["rate"].unit is None


def test_the_later_of_two_settings_counts_and_an_empty_one_resets() -> None:
    assert parse_settings(["rate.unit=deg/s", "rate.unit=mrad/s"]) == {"rate": {"unit": "mrad/s"}}
    mapping = parse_mapping({"extends": "nanobench", "set": {"attitude": {"order": None}}})
    assert mapping.streams[0].channels["attitude"].order == "wxyz"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("rate", "rotor_command"),
        ("rate.unit", "CHANNEL.KEY=VALUE"),
        ("rat.unit=deg/s", "specific_force"),
        ("rate.unti=deg/s", "expressed_in"),
        ("rate.unit=[", "no YAML"),
        ("rate.unit=ft", "rad/s, mrad/s"),
        ("rate.scale=much", "scale"),
        ("rate.order=zyx", "wxyz"),
        ("tilt.euler=true", "attitudes only"),
        ("time.unit=h", "ms, us, ns"),
    ],
)
@pytest.mark.parametrize("command", [import_command, check_command])
def test_a_wrong_setting_is_one_line_with_the_known_names(command: object, text: str, named: str, table: Path) -> None:
    out = ["-o", str(table.with_name("out.parquet"))] if command is import_command else []
    with pytest.raises(UsageError) as error:
        CliRunner().invoke(command, [str(table), "--set", text, *out], catch_exceptions=False)  # type: ignore[arg-type]
    assert "\n" not in str(error.value)
    assert named in str(error.value)
    assert not table.with_name("out.parquet").exists()


def test_a_flight_table_is_imported_again_with_settings(table: Path) -> None:
    GOOD.table.assign(**{n: np.degrees(GOOD.table[n]) for n in ("wx", "wy", "wz")}, px=GOOD.table["px"] * 1e3).pipe(
        lambda wrong: Flight(wrong, {**GOOD.meta, "accept": ["gaps"], "command_steps": 2}).write(table)
    )
    mended = table.with_name("mended.parquet")
    changes = ["--set", "rate.unit=deg/s", "--set", "rotor_command.absolute=true", "--set", "position.scale=0.001"]
    result = CliRunner().invoke(import_command, [str(table), *changes, "-o", str(mended)])
    assert result.exit_code == 0, result.output
    found = read_flight(mended)
    np.testing.assert_allclose(found.get("wx", "wy", "wz"), GOOD.get("wx", "wy", "wz"), atol=1e-12)
    np.testing.assert_allclose(found.get("px"), GOOD.get("px"), atol=1e-12)
    assert found.meta["mapping"] == "flight_table"
    assert found.meta["settings"] == ["rate.unit=deg/s", "rotor_command.absolute=true", "position.scale=0.001"]
    assert (found.meta["accept"], found.meta["command_steps"]) == (["gaps"], 2)


def test_what_a_table_had_derived_is_derived_again(tmp_path: Path) -> None:
    """Rates that came from a quaternion in the wrong order are wrong themselves; they follow the mended attitude."""
    poses = GOOD.table[["t", "px", "py", "pz", "qx", "qy", "qz", "qw"]]
    poses.to_csv(tmp_path / "log.csv", index=False, float_format="%.17g")
    wrong = parse_mapping(
        {
            "name": "wrong",
            "reads": ["table"],
            "time": {"fields": "t"},
            "streams": [{"name": "s", "channels": {"attitude": {"fields": ["qx", "qy", "qz", "qw"]}}}],
        }
    )
    import_log(tmp_path / "log.csv", wrong).write(tmp_path / "wrong.parquet")
    found = import_log(tmp_path / "wrong.parquet", settings={"attitude": {"order": "xyzw"}})
    angle = rotations.angle_between(found.get("qw", "qx", "qy", "qz"), GOOD.get("qw", "qx", "qy", "qz"))
    assert angle.max() < 1e-7
    np.testing.assert_allclose(found.get("wx", "wy", "wz")[5:-5], GOOD.get("wx", "wy", "wz")[5:-5], atol=1e-3)
    assert found.meta["derived"] == ["wx", "wy", "wz"]
    assert found.meta["origin"]["mapping"] == "wrong"


def test_a_setting_on_a_raw_log_reaches_every_stream_with_the_channel(tmp_path: Path) -> None:
    path = write_ned_csv(GOOD, tmp_path / "log.csv")
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(NED_MAPPING))
    found = import_log(path, tmp_path / "m.yaml", settings={"battery": {"unit": "V", "scale": 0.001}})
    np.testing.assert_allclose(found.get("battery"), GOOD.get("battery"), rtol=1e-12)
    result = CliRunner().invoke(
        check_command, [str(path), "--mapping", str(tmp_path / "m.yaml"), "--set", "rate.unit=rad/s"]
    )
    assert result.exit_code == 3, result.output  # degrees read as radians
    assert "--set rate.unit=rad/s" not in result.stdout


@dataclass
class Truth:
    """A log whose rates are in deg/s, 10 ms late, and whose force is mirrored; it is judged by what is still wrong."""

    asked: int = 0

    def __call__(self, settings: Settings) -> list[Finding]:
        self.asked += 1
        rate, force = settings.get("rate", {}), settings.get("specific_force", {})
        found = []
        if rate.get("unit") != "deg/s":
            found.append(finding("rate_unit", "reject", "rate.unit=deg/s"))
        now = float(rate.get("shift", 0.0))
        if abs(now + 0.010) > 1e-6:
            seen = -0.010 if now else -0.007  # the first look sees most of it
            found.append(finding("imu_clock_offset", "warning", f"rate.shift={seen:g}"))
        if "axes" not in force:
            found.append(finding("acceleration_axes", "reject", "specific_force.axes=[x,-y,-z]"))
        return [*found, finding("gaps", "warning"), finding("jitter", "note", "rate.scale=5")]


def finding(code: str, severity: str, *settings: str) -> Finding:
    return Finding(code, severity, f"what {code} says", "effect", "remedy", settings=settings)  # type: ignore[arg-type]


def test_fix_goes_on_until_nothing_is_left_that_a_setting_mends() -> None:
    truth = Truth()
    done = fix(truth, shipped()["flight_table"])
    assert done.settings == {
        "rate": {"unit": "deg/s", "shift": -0.01},
        "specific_force": {"axes": ["x", "-y", "-z"]},
    }
    assert [f.code for f in done.left] == ["gaps"]
    assert [entry[:2] for entry in done.changed] == [
        ("rate.unit=deg/s", "rate_unit"),
        ("specific_force.axes=[x,-y,-z]", "acceleration_axes"),
        ("rate.shift=-0.007", "imu_clock_offset"),
        ("rate.shift=-0.01", "imu_clock_offset"),
    ]
    assert truth.asked == 3


CHANGES: dict[str, tuple[str, dict, str, str]] = {
    "axes turned on top": ("rate", {"axes": ["y", "-x", "z"]}, "rate.axes=[y,-x,z]", "rate.axes=[-x,-y,z]"),
    "axes turned on what was turned": (
        "rate", {"axes": ["y", "z", "x"]}, "rate.axes=[x,-y,-z]", "rate.axes=[y,-z,-x]"
    ),
    "scales multiplied": ("position", {"scale": 0.5}, "position.scale=0.1", "position.scale=0.05"),
    "shifts added": ("velocity", {"shift": 0.02}, "velocity.shift=-0.005", "velocity.shift=0.015"),
    "a world turned back": ("position", {"world": "NED"}, "position.world=NED", "position.world=ENU"),
    "a body turned back": ("rate", {"body": "FRD"}, "rate.body=FRD", "rate.body=FLU"),
    "a body turned on": ("rate", {"body": "RFU"}, "rate.body=FRD", "rate.body=[y,x,-z]"),
    "order of a table": ("attitude", {}, "attitude.order=wxyz", "attitude.order=zwxy"),
    "order of a log": ("attitude", {"order": "xyzw"}, "attitude.order=wxyz", "attitude.order=wxyz"),
    "order set right": ("attitude", {}, "attitude.order=xyzw", "attitude.order=xyzw"),
    "inverse of an inverse": (
        "attitude", {"rotates": "world_to_body"}, "attitude.rotates=world_to_body", "attitude.rotates=body_to_world"
    ),
    "inverse of what is none": (
        "attitude", {}, "attitude.rotates=world_to_body", "attitude.rotates=world_to_body"
    ),
    "a sign of an angle": ("attitude", {}, "attitude.angle_signs=[1,-1,1]", "attitude.angle_signs=[1,-1,1]"),
    "a sign turned back": (
        "attitude", {"angle_signs": [1, -1, 1]}, "attitude.angle_signs=[1,-1,1]", "attitude.angle_signs=[1,1,1]"
    ),
    "a unit as it is": ("rate", {"unit": "deg/s"}, "rate.unit=rad/s", "rate.unit=rad/s"),
    "no reading": ("rate", {}, "nonsense", "nonsense"),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_a_finding_about_the_table_becomes_keys_of_its_mapping(name: str, table: Path) -> None:
    channel, keys, said, wanted = CHANGES[name]
    mapping = with_settings(shipped()["flight_table"], {channel: keys}) if keys else shipped()["flight_table"]
    assert on_top(read_streams(table, mapping).plan, (said,)) == (wanted,)


@pytest.mark.parametrize("name", [n for n in CHANGES if n not in ("a unit as it is", "no reading")])
def test_setting_on_top_is_importing_twice(name: str, tmp_path: Path) -> None:
    """What a setting does to a table that an import made, the setting on top does to the log, in one import."""
    channel, keys, said, wanted = CHANGES[name]
    GOOD.write(tmp_path / "log.parquet")
    mapping = with_settings(shipped()["flight_table"], {channel: keys}) if keys else shipped()["flight_table"]
    import_log(tmp_path / "log.parquet", mapping).write(tmp_path / "once.parquet")
    order = {"attitude.order=wxyz": "attitude.order=zwxy"}  # a table's own columns are never read as x y z w
    twice = import_log(tmp_path / "once.parquet", settings=parse_settings([order.get(said, said)]))
    direct = import_log(tmp_path / "log.parquet", with_settings(mapping, parse_settings([wanted])))
    columns = CHANNELS[channel].columns
    rows = slice(10, -10)
    if channel == "attitude":
        angle = rotations.angle_between(direct.get(*columns)[rows], twice.get(*columns)[rows])
        assert angle.max() < 1e-7
    else:
        # two interpolations in place of one, where the channel is shifted
        atol = 2e-4 if "shift" in said else 1e-12
        np.testing.assert_allclose(direct.get(*columns)[rows], twice.get(*columns)[rows], atol=atol)


def test_fix_undoes_a_round_that_makes_nothing_better() -> None:
    done = fix(lambda settings: [finding("rate_unit", "reject", "rate.unit=deg/s")], shipped()["flight_table"])
    assert (done.settings, done.changed, [f.code for f in done.left]) == ({}, [], ["rate_unit"])


def test_fix_passes_over_settings_that_the_mapping_does_not_take() -> None:
    wrong = [
        finding("rate_unit", "reject", "nonsense"),
        finding("attitude_unit", "reject", "attitude.unit=deg"),  # a table holds quaternions
        finding("attitude_order", "reject", "attitude.order=wxyz"),  # it is so already
    ]

    def judge(settings: Settings) -> list[Finding]:
        return [*wrong, finding("rate_axes", "reject", "rate.axes=[x,-y,-z]")] if not settings else wrong

    done = fix(judge, shipped()["flight_table"])
    assert done.settings == {"rate": {"axes": ["x", "-y", "-z"]}}
    assert [f.code for f in done.left] == ["rate_unit", "attitude_unit", "attitude_order"]


def test_fix_writes_the_table_and_the_mapping_beside_it(table: Path) -> None:
    """End to end: nothing is wrong with a good table, whose mapping then extends its own with no setting."""
    out = table.with_name("fixed.parquet")
    result = CliRunner().invoke(import_command, [str(table), "--fix", "-o", str(out), "--set", "battery.scale=2"])
    assert result.exit_code == 0, result.output
    content = yaml.safe_load(table.with_name("fixed.mapping.yaml").read_text())
    assert content == {"extends": "flight_table", "set": {"battery": {"scale": 2}}}
    again = import_log(table, load_mapping(table.with_name("fixed.mapping.yaml")))
    assert again.table.equals(read_flight(out).table)
    assert "left: " in result.stderr or "nothing that a setting would mend" in result.stderr


def _said_of_no_frame(tmp_path: Path, *left_out: str) -> tuple[Path, Path]:
    """A log in north, east, down and forward, right, down, with a mapping that names neither, without some channels."""
    row = {c: m for c, m in NED_MAPPING["streams"][0]["channels"].items() if c not in left_out}
    content = {k: v for k, v in NED_MAPPING.items() if k not in ("world", "body")}
    (tmp_path / "forgot.yaml").write_text(yaml.safe_dump({**content, "streams": [{"name": "row", "channels": row}]}))
    return write_ned_csv(GOOD, tmp_path / "log.csv"), tmp_path / "forgot.yaml"


@pytest.mark.parametrize("left_out", [(), ("velocity",)])
def test_fix_turns_each_channel_in_the_axes_that_it_is_logged_in(left_out: tuple[str, ...], tmp_path: Path) -> None:
    """A velocity in body axes takes the body's turn; one that the mapping lacks is derived, and stops nothing."""
    log, mapping = _said_of_no_frame(tmp_path, *left_out)
    out = tmp_path / "fixed.parquet"
    result = CliRunner().invoke(import_command, [str(log), "--mapping", str(mapping), "--fix", "-o", str(out)])
    assert result.exit_code == 0, result.output
    assert ("set velocity.body=FRD (world_z_down" in result.stderr) == (not left_out)
    assert "velocity.world" not in result.stderr
    found = read_flight(out)
    for names in (("px", "py", "pz"), ("vx", "vy", "vz"), ("wx", "wy", "wz"), ("ax", "ay", "az")):
        atol = 1e-2 if left_out and names[0] == "vx" else 1e-9
        np.testing.assert_allclose(found.get(*names)[1:-1], GOOD.get(*names)[1:-1], atol=atol, err_msg=names[0])


def test_a_rate_that_is_logged_in_world_axes_takes_the_turn_of_the_world(table: Path) -> None:
    mapping = with_settings(shipped()["flight_table"], {"rate": {"expressed_in": "world"}})
    said = ("attitude.world=NED", "attitude.body=FRD", "rate.body=FRD")
    assert on_top(read_streams(table, mapping).plan, said) == (*said[:2], "rate.world=NED")


def test_fix_leaves_no_file_of_a_log_that_check_still_rejects(tmp_path: Path) -> None:
    still = GOOD.table.assign(px=0.0, py=0.0, pz=0.0, vx=0.0, vy=0.0, vz=0.0, qw=1.0, qx=0.0, qy=0.0, qz=0.0)
    still = still.assign(wx=0.0, wy=0.0, wz=0.0, ax=0.0, ay=0.0, az=9.81, airborne=0.0)
    Flight(still, {}).write(tmp_path / "still.parquet")
    out = tmp_path / "out.parquet"
    result = CliRunner().invoke(import_command, [str(tmp_path / "still.parquet"), "--fix", "-q", "-o", str(out)])
    assert result.exit_code == 3
    assert f"rejected: {tmp_path / 'still.parquet'}: --fix leaves no_flight" in result.stderr
    assert f"infotraj check {tmp_path / 'still.parquet'}" in result.stderr
    assert {f.name for f in tmp_path.iterdir()} == {"still.parquet"}


@pytest.mark.parametrize("extra", [["--explain"], ["-o", "x.parquet", "--allow-damaged"]])
def test_fix_needs_a_place_and_a_whole_log(extra: list[str], table: Path) -> None:
    result = CliRunner().invoke(import_command, [str(table), "--fix", *extra])
    assert isinstance(result.exception, UsageError)


def test_what_no_setting_of_a_table_mends_points_to_its_log(table: Path) -> None:
    plan = read_streams(table, "flight_table").plan
    command_of = "infotraj import LOG --set {} -o NEW.parquet".format
    findings = [
        replace(finding("attitude_unit", "reject", "attitude.unit=deg"), remedy=command_of("attitude.unit=deg")),
        replace(finding("rate_frame", "reject", "rate.expressed_in=body"), remedy=command_of("rate.expressed_in=body")),
        replace(finding("rate_unit", "reject", "rate.scale=0.5"), remedy=command_of("rate.scale=0.5")),
    ]
    degrees, frame, unit = standing(findings, plan)
    assert (degrees.settings, frame.settings, unit.settings) == ((), (), ("rate.scale=0.5",))
    assert degrees.remedy == "import the log that this table was made of anew, with --set attitude.unit=deg"
    assert unit.remedy == command_of("rate.scale=0.5")
    shifted = with_settings(shipped()["flight_table"], {"rate": {"scale": 0.5}})
    (again,) = standing(findings[2:], read_streams(table, shifted).plan)
    assert (again.settings, again.remedy) == (("rate.scale=0.25",), command_of("rate.scale=0.25"))


@pytest.mark.parametrize(
    ("meta", "wanted"),
    [
        (
            {"source_file": "a b.mcap", "mapping": "ros"},
            "infotraj import 'a b.mcap' --mapping ros --set {} -o NEW.parquet",
        ),
        (
            {"source_file": "a.csv", "mapping": "mine", "settings": ["rate.unit=deg/s"]},
            "infotraj import a.csv --mapping mine.yaml --set rate.unit=deg/s --set {} -o NEW.parquet "
            "(mine.yaml: your file of the mapping mine)",
        ),
        (
            {"mapping": "flight_table", "origin": {"source_file": "a.ulg", "mapping": "px4_ulog"}},
            "infotraj import a.ulg --mapping px4_ulog --set {} -o NEW.parquet",
        ),
    ],
)
def test_the_log_that_a_table_was_made_of_is_named_and_not_the_table(
    meta: dict[str, object], wanted: str, table: Path
) -> None:
    """World velocities that were turned as body ones: the table cannot say so, its log can."""
    turned = rotations.to_world(GOOD.get("qw", "qx", "qy", "qz"), GOOD.get("vx", "vy", "vz"))
    wrong = GOOD.table.assign(**dict(zip(("vx", "vy", "vz"), turned.T, strict=True)))
    Flight(wrong, meta).write(table)
    result = CliRunner().invoke(check_command, [str(table)])
    assert result.exit_code == 3
    (line,) = [k for k in result.stdout.splitlines() if "do: " in k and "velocity.expressed_in" in k]
    assert f"do: with the log that this table was made of: {wanted.format('velocity.expressed_in=world')}, or" in line
