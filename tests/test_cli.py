"""The command line's front door: every command loads, errors are one line with their exit status."""

import subprocess
import sys
from pathlib import Path

import click
import pytest

from infotraj import cli


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
