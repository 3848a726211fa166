"""The command that comes next runs as it stands, on what the command before it was given."""

import shlex
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.checking.settings import by_mapping, of_log
from infotraj.cli import cli
from infotraj.diagnosis.report.following import next_command, recording_command
from infotraj.errors import InputError, UsageError
from infotraj.flight import Flight, read_flight
from infotraj.importing.foreign import foreign
from infotraj.importing.log import what_is_left
from infotraj.recording import read_back
from infotraj.suggested import again, quoted, unused

QUADROTOR = Path(__file__).parents[1] / "config" / "vehicles" / "quadrotor.yaml"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
ODD = "it's a $HOME"
READ = ("--from", "1", "--to", "7", "--accept", "copy", "--command-steps", "2")
SEED = ("--seed", "3")


@pytest.fixture(scope="module")
def flown():
    content = yaml.safe_load(QUADROTOR.read_text())
    return [fly(content, {"linear_drag": {"d": [0.1, 0.1, 0.1]}}, seconds=8.0, seed=k, noise=NOISE) for k in range(2)]


@pytest.fixture
def names(flown, tmp_path, monkeypatch):
    """A model and flights with names that a shell or a command would take for something else."""
    monkeypatch.chdir(tmp_path)
    Path(ODD).mkdir()
    Path(ODD, "quad.yaml").write_text(QUADROTOR.read_text())
    flown[0].to_parquet("-q.parquet")
    flown[1].to_parquet(Path(ODD, "b.parquet"))
    return [f"{ODD}/quad.yaml", "./-q.parquet"]


def told(*words):
    """The words of the line `next:`, as a shell takes them."""
    result = CliRunner().invoke(cli, [str(w) for w in words])
    assert isinstance(result.exception, (type(None), SystemExit)), result.exception
    (line,) = [x for x in result.stderr.splitlines() if x.startswith("next: ")]
    return shlex.split(line.removeprefix("next: infotraj "))


def runs(words):
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 0, (words, result.output, result.exception)


def after(option, words):
    return words[words.index(option) + 1]


@pytest.mark.parametrize(
    ("words", "options", "following"),
    [
        (("compare",), (*READ, *SEED, "--window", "0.2", "--force-from", "velocity"), "locate"),
        (("locate",), (*READ, *SEED), "diagnose"),
        pytest.param(
            ("diagnose",), (*READ, *SEED, "--matters", "0.1", "--seconds", "20"), "diagnose", marks=pytest.mark.long
        ),
        pytest.param(("diagnose", "--save-model", "mine.yaml"), (*READ, *SEED), "compare", marks=pytest.mark.long),
    ],
)
def test_how_flights_were_read_is_handed_on_and_names_are_quoted(words, options, following, names):
    command, *own = words
    said = told(command, *names, *own, *options)
    assert said[0] == following
    assert [n for n in said if n in names] == ([names[1], names[0]] if following == "compare" else names)
    for option, value in zip(options[::2], options[1::2], strict=True):
        assert after(option, said) == value
    runs(said)


def test_what_was_added_is_compared_on_the_part_that_was_fitted(names):
    said = told("add", names[0], "linear_drag", "--fit", names[1], "-o", f"{ODD}/new.yaml", *READ)
    assert said[:5] == ["compare", f"{ODD}/new.yaml", names[1], "--against", names[0]]
    assert sorted(said[5:]) == sorted(READ)
    runs(said)


def test_poses_alone_are_imported_before_errors_are_asked_for(names, flown, tmp_path):
    """An import derives velocity and rates; without them there is no measured force or torque."""
    poses = flown[0].drop(columns=["vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az"])
    poses.to_parquet("-p.parquet")
    said = told("compare", names[0], "./-p.parquet")
    assert said == ["import", "./-p.parquet", "-o", "flights/"]
    runs(said)
    runs(["locate", names[0], "flights/-p.parquet"])
    alone = CliRunner().invoke(cli, ["locate", names[0], "./-p.parquet"])
    assert "`infotraj import` derives velocity and rates from its poses." in str(alone.exception)
    found = SimpleNamespace(
        supported=(), beside=(), command_steps=1, by_velocity=False, healthy=None,
        before=SimpleNamespace(rows=np.zeros(6)),
        samples=[SimpleNamespace(flight=Flight(poses, {"source": "p.parquet"}))],
    )  # fmt: skip
    assert next_command(found, Path("m.yaml"), None) == "infotraj import p.parquet -o flights-2/"
    found.supported = ("linear_drag",)
    assert next_command(found, Path("m.yaml"), None).startswith("infotraj diagnose m.yaml p.parquet --save-model")
    assert next_command(found, Path("m.yaml"), Path("new.yaml")).startswith("infotraj import")
    found.samples = [SimpleNamespace(flight=Flight(flown[0], {"source": "p.parquet"}))]
    assert next_command(found, Path("m.yaml"), Path("new.yaml")) == "infotraj check p.parquet --vehicle m.yaml"


def test_logs_that_tell_a_balance_alone_are_held_against_healthy_ones(names, flown):
    """Without attitude, gyro and accelerometer no error can be said, and a diagnosis takes the vehicle as level."""
    lost = ["qw", "qx", "qy", "qz", "wx", "wy", "wz", "ax", "ay", "az"]
    for name, table in zip(("now.parquet", "then.parquet"), flown, strict=False):
        table.drop(columns=lost).to_parquet(name)
    said = told("compare", names[0], "now.parquet", "--reference", "then.parquet")
    assert said == ["diagnose", names[0], "now.parquet", "--reference", "then.parquet"]
    runs(said)
    assert told("compare", names[0], "now.parquet")[0] == "check"
    located = CliRunner().invoke(cli, ["locate", names[0], "now.parquet", "--reference", "then.parquet"])
    assert "`infotraj diagnose --reference` holds its balance" in str(located.exception)


def test_an_option_that_the_next_command_has_not_is_left_out(names):
    said = told("locate", *names, "--window", "0.2", "--force-from", "velocity", "--least-excess", "0.3")
    assert not {"--window", "--force-from", "--least-excess", "--seed", "--from"} & set(said)


@pytest.mark.parametrize(
    ("command", "following"),
    [("compare", "locate"), pytest.param("locate", "diagnose", marks=pytest.mark.long)],
)
def test_a_reference_is_handed_on_with_quotes(command, following, names):
    said = told(command, *names, "--reference", f"{ODD}/b.parquet", "--from", "1")
    assert said[0] == following
    assert after("--reference", said) == f"{ODD}/b.parquet"
    runs(said)


def test_after_a_diagnosis_the_healthy_flights_that_were_used_are_handed_on():
    used, healthy = (
        [SimpleNamespace(meta={"source": f"{n}.parquet"}) for n in names] for names in (("a",), ("b c", "-d"))
    )
    found = SimpleNamespace(
        supported=("linear_drag",), beside=(), command_steps=1, by_velocity=False,
        healthy=SimpleNamespace(flights=healthy),
        before=SimpleNamespace(rows=np.ones(6)),
        samples=[SimpleNamespace(flight=f) for f in used],
    )  # fmt: skip
    said = next_command(found, Path("m.yaml"), None)
    assert said == "infotraj locate m.yaml a.parquet --reference 'b c.parquet' ./-d.parquet"
    found.healthy = None
    assert "--reference" not in next_command(found, Path("m.yaml"), None)


@pytest.mark.long
def test_a_recording_is_of_the_new_model_and_of_the_one_that_it_is_held_against(names):
    """The first is written to a file, or in the answer alone; where nothing is new the model as given is recorded."""
    found = SimpleNamespace(
        supported=("linear_drag",), beside=(), command_steps=1, by_velocity=False, healthy=None,
        before=SimpleNamespace(rows=np.ones(6)),
        after="better", samples=[SimpleNamespace(flight=SimpleNamespace(meta={"source": names[1]}))],
    )  # fmt: skip
    model, flight = Path(names[0]), quoted(names[1])
    Path("worst.rrd").touch()
    said = recording_command(found, model, Path("new.yaml"))
    assert said == f"infotraj compare new.yaml {flight} --against {quoted(model)} --recording worst-2.rrd"
    said = recording_command(found, model, None)
    assert said == f"infotraj diagnose {quoted(model)} {flight} --recording worst-2.rrd"
    runs(shlex.split(said.removeprefix("infotraj ")))
    assert read_back("worst-2.rrd")["wrench/fx/predicted_2"]["SeriesLines:names"] == ["the model as given"]
    found.healthy = SimpleNamespace(flights=[SimpleNamespace(meta={"source": "b c.parquet"})])
    said = recording_command(found, model, None)
    assert said == f"infotraj diagnose {quoted(model)} {flight} --recording worst-3.rrd --reference 'b c.parquet'"
    found.after = found.before
    said = recording_command(found, model, None)
    assert said == f"infotraj compare {quoted(model)} {flight} --recording worst-3.rrd --reference 'b c.parquet'"
    found.by_velocity = True
    assert recording_command(found, model, None) == f"{said} --force-from velocity"
    assert next_command(found, model, None).endswith("--force-from velocity")
    found.healthy = None
    assert "--force-from" not in next_command(found, model, None)


@pytest.mark.long
def test_a_new_model_has_a_name_that_no_file_has(names):
    Path("new.yaml").write_text(QUADROTOR.read_text())
    said = told("diagnose", "new.yaml", names[1])
    assert after("--save-model", said) == "new-2.yaml"
    runs(said)
    assert unused("new.yaml") == "new-3.yaml"
    assert unused("other.yaml") == "other.yaml"


@pytest.mark.parametrize("command", ["compare", "locate", "diagnose", "report"])
def test_no_flight_is_its_own_reference(command, names):
    output = ["-o", "a.html"] if command == "report" else []
    result = CliRunner().invoke(cli, [command, *names, "--reference", names[1], *output])
    assert isinstance(result.exception, UsageError)
    assert "is asked about and healthy at once" in str(result.exception)


def test_a_shell_takes_quoted_names_for_what_they_are():
    paths = ["a b.csv", "it's", "-x.csv", Path("plain.csv"), "$HOME", "a;b"]
    assert shlex.split(quoted(*paths)) == ["a b.csv", "it's", "./-x.csv", "plain.csv", "$HOME", "a;b"]
    assert quoted("plain.csv") == "plain.csv"


def test_what_would_mend_a_log_takes_its_name_for_what_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = "infotraj import LOG --set rate.unit=deg/s -o NEW.parquet"
    Path("-x.txt").write_text("t,px\n0,1\n")
    with pytest.raises(InputError) as text:
        read_flight("-x.txt")
    Path("-x y.csv").write_text("t,px,py\n0,1,2\n1,2,3\n2,3\n")
    with pytest.raises(InputError) as cut:
        read_flight("-x y.csv")
    for said, name in (
        (str(text.value), "./-x.txt"),
        (str(cut.value), "'./-x y.csv'"),
        (what_is_left(Path("-x.ulg")), "./-x.ulg"),
        (of_log(settings, "-x.csv"), "./-x.csv"),
        (by_mapping(settings, "-x.yaml"), "--mapping ./-x.yaml"),
        (" ".join(foreign(b"\x1f\x8b", Path("-x.gz"))), "gunzip -k ./-x.gz"),
    ):
        assert f" {name} " in f"{said} ", said


def test_without_a_running_command_only_what_was_found_is_repeated():
    assert again("compare") == ""
    assert again("compare", command_steps=2) == " --command-steps 2"
