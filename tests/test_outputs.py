"""Outputs are tried before a command computes: none is an input or another output, and each can be written."""

import os
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.cli import cli
from infotraj.errors import InfotrajError, UsageError
from infotraj.models import Model, save_model
from infotraj.models.content import FileReference, Provenance
from infotraj.outputs import require_outputs
from infotraj.vehicle import load_vehicle

QUADROTOR = Path(__file__).parents[1] / "config" / "vehicles" / "quadrotor.yaml"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A vehicle file, a model of it, and its own model; tables that no command can read as flights."""
    monkeypatch.chdir(tmp_path)
    Path("quad.yaml").write_text(QUADROTOR.read_text())
    for parent, new in (("quad.yaml", "first.yaml"), ("first.yaml", "second.yaml")):
        made_from = FileReference(path=str(Path(parent).resolve()), sha256="0" * 64)
        save_model(Model(load_vehicle("quad.yaml")), new, provenance=Provenance(parent=made_from))
    Path("named.yaml").write_text(yaml.safe_dump({"vehicle": "quad.yaml"}))
    for name in ("f.csv", "f.meta.yaml", "g.parquet", "own.py", "r.json"):
        Path(name).write_text("source: none\n")
    Path("base.yaml").write_text("extends: flight_table\n")
    Path("n.mapping.yaml").write_text("extends: base.yaml\n")
    Path("bag").mkdir()
    for name in ("metadata.yaml", "a.db3"):
        Path("bag", name).write_text("source: none\n")
    return tmp_path


ADD = ("add", "second.yaml", "linear_drag", "--fit", "f.csv")
IMPORT = ("import", "f.csv", "-o", "n.parquet")
MAPPED = (*IMPORT, "--mapping", "n.mapping.yaml")
NEW = ["vehicle", "new", "--layout", "quad_x", "--order", "px4", "--arm", "0.2", "--mass", "1", "--propeller", "0.25"]
MANY = ("diagnose", "second.yaml", "f.csv", "--reference", "g.parquet", "--effects-from")


@pytest.mark.parametrize(
    "words",
    [
        *[(*ADD, "-o", name) for name in ("f.csv", "f.meta.yaml", "second.yaml", "first.yaml", "quad.yaml")],
        (*ADD, "-o", "new.yaml", "--json", "new.yaml"),
        (*ADD, "-o", "new.yaml", "--json", "../{folder}/f.csv"),
        (*ADD, "-o", "new.yaml", "--json", "linked.csv"),
        ("add", "named.yaml", "linear_drag", "--fit", "f.csv", "-o", "quad.yaml"),
        ("diagnose", "quad.yaml", "f.csv", "--save-model", "f.csv"),
        ("diagnose", "quad.yaml", "f.csv", "--save-model", "s.yaml", "--json", "./s.yaml"),
        ("diagnose", "quad.yaml", "f.csv", "--figures", "d", "--json", "d"),
        *[(*MANY, "own.py", "--json", name) for name in ("own.py", "g.parquet", "quad.yaml")],
        (*MANY, ".", "--recording", "own.py"),
        ("compare", "quad.yaml", "f.csv", "--json", "quad.yaml"),
        ("compare", "quad.yaml", "f.csv", "--against", "second.yaml", "--json", "first.yaml"),
        ("compare", "quad.yaml", "f.csv", "--reference", "g.parquet", "--json", "g.parquet"),
        ("locate", "quad.yaml", "f.csv", "--json", "f.csv"),
        ("design", "quad.yaml", "--flown", "f.csv", "-o", "f.csv"),
        ("report", "quad.yaml", "f.csv", "-o", "f.csv"),
        ("report", "--from-json", "r.json", "-o", "r.json"),
        ("history", "second.yaml", "--json", "quad.yaml"),
        *[("check", "f.csv", "--json", name) for name in ("f.csv", "f.meta.yaml")],
        *[("check", "bag", "--json", name) for name in ("bag/metadata.yaml", "bag/a.db3")],
        ("check", "f.csv", "--mapping", "n.mapping.yaml", "--json", "base.yaml"),
        ("import", "f.csv", "-o", "f.csv"),
        ("import", "g.parquet", "--with", "f.csv", "-o", "f.csv"),
        ("import", "g.parquet", "-o", "n.csv", "--json", "n.meta.yaml"),
        *[(*IMPORT, "--save-mapping", name) for name in ("f.csv", "f.meta.yaml", "n.parquet")],
        *[(*MAPPED, "--json", name) for name in ("f.csv", "n.mapping.yaml", "base.yaml", "n.parquet")],
        (*MAPPED, "--fix"),
        (*IMPORT, "--definitions", "own.py", "--json", "own.py"),
        ("effects", "--effects", "own.py", "--json", "own.py"),
        (*NEW, "-o", "v.yaml", "--flight", "v.yaml"),
        ("check", "f.csv", "--vehicle", "quad.yaml", "--json", "quad.yaml"),
    ],
    ids=" ".join,
)
def test_no_output_is_an_input_or_another_output(words, folder):
    os.link("f.csv", "linked.csv")
    before = contents(folder)
    result = CliRunner().invoke(cli, [w.replace("{folder}", folder.name) for w in words])
    assert isinstance(result.exception, UsageError), result.output
    assert "Choose another name" in str(result.exception)
    assert "\n" not in str(result.exception)
    assert contents(folder) == before


def contents(folder):
    return {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize(
    "words", [("effects",), ("compare", "quad.yaml", "g.parquet"), ("diagnose", "quad.yaml", "f.csv")]
)
def test_effects_that_the_environment_names_are_no_outputs(words, folder, monkeypatch):
    monkeypatch.setenv("INFOTRAJ_EFFECTS", str(folder))
    before = contents(folder)
    result = CliRunner().invoke(cli, [*words, "--json", "own.py"])
    assert isinstance(result.exception, UsageError), result.output
    assert "--json own.py is a file with effects that are read" in str(result.exception)
    assert contents(folder) == before


@pytest.mark.parametrize("words", [IMPORT[:2], ("effects",), tuple(NEW)])
def test_a_closed_place_is_named_before_anything_is_asked_or_read(words, folder):
    output = "f.csv/new.yaml" if words == tuple(NEW) else "f.csv/new.parquet"
    result = CliRunner().invoke(cli, [*words, "--json" if words == ("effects",) else "-o", output])
    assert type(result.exception) is InfotrajError, result.output
    assert "lies in f.csv, which is a file" in str(result.exception)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("", "is a folder"), (".", "is a folder"), ("f.csv/a.json", "f.csv, which is a file"),
        ("f.csv/a/b.json", "f.csv, which is a file"), ("/dev/null", "no plain file"),
        ("/proc/none/a.json", "cannot be written"), ("n" * 300, "cannot be written"),
    ],
)  # fmt: skip
def test_a_place_that_cannot_be_written_is_named_before_anything_is_read(place, said, folder):
    result = CliRunner().invoke(cli, ["diagnose", "quad.yaml", "none.csv", "--json", place])
    assert type(result.exception) is InfotrajError
    assert said in str(result.exception)
    assert "\n" not in str(result.exception)


def test_a_folder_that_is_a_file_is_named(folder):
    for command in ("compare", "locate", "diagnose"):
        for place in ("r.json", "r.json/sub"):
            result = CliRunner().invoke(cli, [command, "quad.yaml", "none.csv", "--figures", place])
            assert type(result.exception) is InfotrajError
            assert "r.json" in str(result.exception)


def test_what_can_be_written_passes_and_trying_leaves_nothing(folder):
    before = sorted(folder.rglob("*"))
    files = {"-o": Path("new/deep/m.yaml"), "--json": Path("r.json"), "--recording": None}
    require_outputs(files, {"--figures": Path("figures/of/it")}, {"a flight": [Path("f.csv"), Path("none.csv")]})
    assert sorted(folder.rglob("*")) == before
    assert Path("r.json").read_text() == "source: none\n"


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is closed to the superuser")
def test_a_folder_that_is_closed_is_named(folder):
    Path("closed").mkdir(mode=0o500)
    with pytest.raises(InfotrajError, match="Permission denied"):
        require_outputs({"--json": Path("closed/new/a.json")}, {}, {})


@pytest.mark.parametrize(
    ("words", "writer"),
    [
        (("diagnose", "{flight}", "--json", "new/a.json"), "infotraj.comparing.files.write_json"),
        pytest.param(
            ("diagnose", "{flight}", "--save-model", "new/m.yaml"),
            "infotraj.diagnosis.report.saving.save_model",
            marks=pytest.mark.long,
        ),
        (("compare", "{flight}", "--json", "new/a.json"), "infotraj.comparing.files.write_json"),
        (("locate", "{flight}", "--json", "new/a.json"), "infotraj.comparing.files.write_json"),
        (
            ("add", "linear_drag", "--fit", "{flight}", "-o", "new/m.yaml"),
            "infotraj.diagnosis.report.saving.save_model",
        ),
        (("effects", "--json", "new/a.json"), "infotraj.effects.command.whole"),
        (("import", "{flight}", "--explain", "-o", "new/a.csv"), "infotraj.flight.whole"),
    ],
)
def test_the_answer_is_shown_though_a_file_cannot_be_written_after_all(words, writer, folder, monkeypatch, flown_once):
    def fails(*_, **__):
        raise InfotrajError("the disk is full")

    monkeypatch.setattr(writer, fails)
    command, *rest = (w.replace("{flight}", str(flown_once)) for w in words)
    model = [] if command in ("effects", "import") else ["quad.yaml"]
    result = CliRunner().invoke(cli, [command, *model, *rest])
    assert str(result.exception) == "the disk is full"
    assert {"effects": "linear_drag", "import": "velocity"}.get(command, "fx") in result.stdout


@pytest.mark.parametrize("place", ["", "sub", "f.csv/m.yaml", "/proc/none/m.yaml"])
def test_a_model_that_cannot_be_written_is_one_line(place, folder):
    Path("sub").mkdir()
    before = sorted(folder.rglob("*"))
    with pytest.raises(InfotrajError, match="expected a file that can be written"):
        save_model(Model(load_vehicle("quad.yaml")), place)
    assert sorted(folder.rglob("*")) == before


@pytest.fixture(scope="module")
def flown_once(tmp_path_factory):
    path = tmp_path_factory.mktemp("flown") / "flight.parquet"
    noise = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
    fly(
        yaml.safe_load(QUADROTOR.read_text()), {"linear_drag": {"d": [0.1, 0.1, 0.1]}}, seconds=8.0, noise=noise
    ).to_parquet(path)
    return path
