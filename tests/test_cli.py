"""The command line's front door: every command loads, errors are one line with their exit status."""

import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
import yaml
from click.testing import CliRunner

from infotraj import __version__, cli

QUAD = Path(__file__).parents[1] / "examples" / "quad"


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "infotraj.cli", *arguments], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("name", list(cli.COMMANDS))
def test_every_command_loads_and_explains_itself(name):
    command = cli.cli.get_command(None, name)
    assert isinstance(command, click.Command)
    assert command.name == name
    assert command.help


def test_help_names_every_command_without_loading_them():
    code = (
        "import sys, infotraj.cli as c; from click.testing import CliRunner; "
        "out = CliRunner().invoke(c.cli, ['--help']).output; "
        "assert all(n in out for n in c.COMMANDS), out; assert 'numpy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_missing_log_is_one_line_and_status_3(tmp_path):
    done = run("import", str(tmp_path / "none.csv"), "-o", str(tmp_path / "out.parquet"))
    assert done.returncode == 3
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("all_of_it", [True, False])
def test_files_are_written_though_nobody_reads_the_answer(all_of_it, tmp_path):
    """As in `infotraj compare ... --json a.json | head -1`, and with `2>&1` before the pipe."""
    out = tmp_path / "a.json"
    ours, theirs = os.pipe()
    os.close(ours)
    words = ["compare", "vehicle.yaml", "flight_0.parquet", "--json", str(out)]
    heard = subprocess.STDOUT if all_of_it else subprocess.PIPE
    done = subprocess.run(
        [sys.executable, "-m", "infotraj.cli", *words], stdout=theirs, stderr=heard, text=True, cwd=QUAD, check=False
    )
    os.close(theirs)
    assert done.returncode == 0
    assert "rmse" in out.read_text()
    assert all_of_it or done.stderr.startswith("next: ")


ANSWERS = ["effects", "data list", "history vehicle.yaml"]


def in_shell(words, redirected):
    line = f"{sys.executable} -m infotraj.cli {words} {redirected}"
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, cwd=QUAD, check=False)


@pytest.mark.parametrize("words", ANSWERS)
def test_an_answer_that_nobody_reads_is_no_failure(words):
    """As in `infotraj effects | head -1`, and with the output closed."""
    ours, theirs = os.pipe()
    os.close(ours)
    words_of = [sys.executable, "-m", "infotraj.cli", *words.split()]
    done = subprocess.run(words_of, stdout=theirs, stderr=subprocess.PIPE, text=True, cwd=QUAD, check=False)
    os.close(theirs)
    closed = in_shell(words, ">&-")
    assert (done.returncode, closed.returncode) == (0, 0), done.stderr + closed.stderr
    assert closed.stderr == done.stderr
    assert "error" not in done.stderr


def test_closed_input_is_no_terminal():
    done = in_shell("vehicle new -o none.yaml", "<&-")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full device")
@pytest.mark.parametrize("words", ["effects", "history vehicle.yaml", "--help"])
def test_an_answer_that_cannot_be_written_is_one_line_and_status_1(words):
    done = in_shell(words, "> /dev/full")
    assert done.returncode == 1
    wrong = [line for line in done.stderr.splitlines() if not line.lower().startswith("next: ")]
    assert len(wrong) == 1
    assert "standard output" in wrong[0]


def test_the_version_is_one_and_every_page_that_states_it_agrees():
    top = Path(__file__).parents[1]
    assert run("--version").stdout.strip() == f"infotraj, version {__version__}"
    assert yaml.safe_load((top / "CITATION.cff").read_text())["version"] == __version__
    assert f"\n## {__version__}\n" in (top / "CHANGELOG.md").read_text()


def test_an_unknown_command_is_usage():
    done = run("frobnicate")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_history_starts_without_what_evaluates_a_model():
    code = (
        "import sys; from click.testing import CliRunner; "
        "from infotraj.diagnosis.report.command import history_command; "
        "done = CliRunner().invoke(history_command, ['config/vehicles/quadrotor.yaml']); "
        "assert done.exit_code == 0, done.output; "
        "heavy = {'scipy', 'pandas', 'numba', 'matplotlib'} & set(sys.modules); assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[1])


def test_a_check_without_options_loads_nothing_of_the_command_that_it_suggests():
    code = (
        "import sys; from click.testing import CliRunner; from infotraj.cli import cli; "
        "done = CliRunner().invoke(cli, ['check', 'examples/quad/flight_0.parquet']); "
        "assert 'next: infotraj compare' in done.stderr, done.output; "
        "assert not any(m.startswith('infotraj.comparing') for m in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[1])


def every_command():
    """Every command with its words: `diagnose`, `vehicle new`, ..."""
    for name in cli.COMMANDS:
        command = cli.cli.get_command(None, name)
        if isinstance(command, click.Group):
            yield from ((name, inner) for inner in command.commands)
        yield (name,)


@pytest.mark.parametrize("words", list(every_command()), ids=" ".join)
def test_help_fits_in_80_columns_without_colours(words):
    done = CliRunner().invoke(cli.cli, [*words, "--help"], terminal_width=80, color=True)
    assert done.exit_code == 0, done.output
    assert max(map(len, done.output.splitlines())) <= 80
    assert "\x1b" not in done.output


def test_answers_have_no_colours_even_where_they_are_forced(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    top = Path(__file__).parents[1]
    done = run("check", str(top / "examples/quad/flight_0.parquet"))
    assert done.returncode == 0, done.stderr
    assert "\x1b" not in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("infotraj di", {"diagnose"}),
        ("infotraj vehicle ", {"new", "check"}),
        ("infotraj diagnose --ref", {"--reference"}),
    ],
)
def test_a_shell_completes_commands_and_options(words, offered):
    """As bash asks: the words so far and which of them is being typed."""
    asked = {"COMP_WORDS": words, "COMP_CWORD": str(len(words.split(" ")) - 1), "_INFOTRAJ_COMPLETE": "bash_complete"}
    code = "from infotraj.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **asked}, capture_output=True, text=True, check=True
    )
    assert {line.partition(",")[2] for line in done.stdout.splitlines()} == offered


def test_the_first_run_says_on_a_terminal_why_it_takes_long(monkeypatch, capsys, tmp_path):
    (tmp_path / "models").mkdir()
    monkeypatch.setattr(cli, "__file__", str(tmp_path / "cli.py"))
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(sys, "argv", ["infotraj", "diagnose", "m", "f"])
    cli._said_once("history")
    assert capsys.readouterr().err == ""
    cli._said_once("diagnose")
    assert "first run: compiling" in capsys.readouterr().err
    (tmp_path / "models" / "__pycache__").mkdir()
    (tmp_path / "models" / "__pycache__" / "a.nbi").touch()
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    cli._said_once("diagnose")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("words", "following"),
    [
        (["compare", QUAD / "vehicle.yaml", QUAD / "flight_0.parquet"], "infotraj locate "),
        (["check", QUAD / "flight_0.parquet"], "infotraj compare MODEL "),
        (["doctor", QUAD / "vehicle.yaml", QUAD / "flight_0.parquet"], "infotraj diagnose "),
        (["vehicle", "check", QUAD / "vehicle.yaml"], "infotraj compare "),
        (["import", QUAD / "flight_0.parquet", "-o", "OUT/a.parquet"], "infotraj check "),
        (["examples", "OUT"], "infotraj diagnose "),
    ],
)
def test_quiet_hides_messages_and_not_what_comes_next(words, following, tmp_path):
    said = [str(w).replace("OUT", str(tmp_path)) for w in words]
    done = CliRunner().invoke(cli.cli, [*said, "-q"])
    assert done.exit_code == 0, done.output
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"next: {following}")


NUMBERS = [
    ("compare", "--window", "nan"), ("compare", "--window", "inf"), ("compare", "--from", "nan"),
    ("locate", "--least-excess", "nan"), ("locate", "--to", "inf"), ("diagnose", "--matters", "nan"),
    ("diagnose", "--seconds", "inf"), ("report", "--matters", "nan"), ("check", "--from", "nan"),
    ("import", "--to", "nan"), *[(c, "--seed", "-1") for c in ("compare", "locate", "diagnose", "add", "design")],
    *[(c, "--command-steps", "201") for c in ("compare", "locate", "diagnose", "add", "design", "report")],
]  # fmt: skip


@pytest.mark.parametrize("words", NUMBERS, ids=" ".join)
def test_a_number_that_is_none_or_beyond_all_use_is_refused(words):
    command, option, value = words
    done = CliRunner().invoke(cli.cli, [command, "m.yaml", option, value, "f.csv"])
    assert done.exit_code == 2
    assert f"Invalid value for '{option}'" in done.output


def test_every_option_that_takes_a_number_takes_a_finite_one():
    for name in cli.COMMANDS:
        command = cli.cli.get_command(None, name)
        for one in [command, *getattr(command, "commands", {}).values()]:
            for option in one.params:
                if isinstance(option.type, click.types.FloatParamType):
                    with pytest.raises(click.BadParameter, match="finite"):
                        option.type.convert("nan", option, None)
