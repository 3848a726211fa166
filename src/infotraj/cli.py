"""The command line: `infotraj COMMAND ...`. Each command lives beside what it calls; here they get one front door."""

from __future__ import annotations

import atexit
import importlib
import io
import os
import sys
from pathlib import Path
from typing import Any

import click

from infotraj import __version__
from infotraj.errors import InfotrajError, problem

# A command's module is imported when the command is called: `infotraj --help` need not load numpy.
COMMANDS = {
    "import": ("infotraj.importing.command:import_command", "Turn a log into a flight table."),
    "check": ("infotraj.checking.command:check_command", "Does a log mean what it says?"),
    "doctor": ("infotraj.describing.doctor:doctor_command", "What stands between a flight and an answer, in a line."),
    "compare": ("infotraj.comparing.command:compare_command", "Model against measurement."),
    "locate": ("infotraj.locating.command:locate_command", "Where a model fails."),
    "diagnose": ("infotraj.diagnosis.report.command:diagnose_command", "Which physical effect a model lacks."),
    "add": ("infotraj.diagnosis.report.command:add_command", "Add effects to a model, fitted to flights."),
    "history": ("infotraj.diagnosis.report.command:history_command", "How the error fell, version by version."),
    "report": ("infotraj.report.command:report_command", "A diagnosis as one HTML page."),
    "app": ("infotraj.app.command:app_command", "The same in a browser: a local web app."),
    "design": ("infotraj.design.command:design_command", "The flight that tells most next."),
    "effects": ("infotraj.effects.command:effects_command", "The catalogue of physical effects."),
    "vehicle": (
        "infotraj.describing.command:vehicle_command",
        "Write a first vehicle file; hold one against a flight.",
    ),
    "examples": ("infotraj.examples.command:examples_command", "Copy example flights and vehicle files."),
    "data": ("infotraj.datasets.command:data_command", "Get or list public data sets."),
}


# These compile what they compute with; what is compiled is kept beside the modules, or where NUMBA_CACHE_DIR says.
_COMPUTING = {"doctor", "compare", "locate", "diagnose", "add", "design", "report"}


def _said_once(command: str | None) -> None:
    """On a terminal, before the first run of a command that compiles: why it takes longer than it will."""
    compiled = Path(__file__).parent / "models" / "__pycache__"
    kept_here = "NUMBA_CACHE_DIR" not in os.environ and os.access(compiled.parent, os.W_OK)
    computing = command in _COMPUTING and not {"-h", "--help"} & set(sys.argv)
    if computing and sys.stderr.isatty() and kept_here and not any(compiled.glob("*.nbi")):
        click.echo("first run: compiling, about 20 s of CPU time; later runs start at once", err=True)


class _Commands(click.Group):
    """The commands of COMMANDS, loaded late, with errors told in one line."""

    def list_commands(self, context: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module, _, attribute = COMMANDS[name][0].partition(":")
        return getattr(importlib.import_module(module), attribute)

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120})
@click.version_option(__version__, prog_name="infotraj")
@click.pass_context
def cli(context: click.Context) -> None:
    """Finds out what is missing in a robot's model, and collects the flights that teach it."""
    _said_once(context.invoked_subcommand)


def main() -> None:
    """Runs the command line. Exit status: 0 done, 1 failed, 2 usage, 3 a log was rejected, 4 a threshold was passed."""
    # Small matrices are slower with several BLAS threads; a user's own setting wins.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    sys.stdin = sys.stdin or open(os.devnull)  # noqa: SIM115 - for as long as the process lives
    sys.stdout, sys.stderr = _dropping(sys.stdout), _dropping(sys.stderr)
    try:
        cli(prog_name="infotraj")
    except InfotrajError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(error.exit_status)
    finally:
        _no_escape_code_at_the_end()
        _require_written(sys.stdout)


class _Dropping(io.FileIO):
    """An output that may end early, as in `infotraj ... | head -1` or on a full disk: what is not taken is dropped,
    and the command goes on to write its files. `failed`: why, where it was not that the reader had gone."""

    failed: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except BrokenPipeError:
            return len(data)
        except OSError as error:
            self.failed = error
            return len(data)


def _dropping(stream: Any) -> Any:
    """The stream over `_Dropping`; a terminal, or what is no file of this process, as it is. Where the shell has closed
    it (`>&-`), one that nobody reads."""
    if stream is None:
        return open(os.devnull, "w")
    if stream not in (sys.__stdout__, sys.__stderr__) or stream.isatty():
        return stream
    raw = io.BufferedWriter(_Dropping(stream.fileno(), "w", closefd=False))
    return io.TextIOWrapper(raw, stream.encoding, stream.errors, line_buffering=stream.line_buffering)


def _require_written(stream: Any) -> None:
    """Exit status 1, and one line, where a part of the answer could not be written."""
    stream.flush()
    failed = getattr(getattr(getattr(stream, "buffer", None), "raw", None), "failed", None)
    if failed is not None:
        found = f"the answer could not be written ({failed.strerror})"
        click.echo(f"error: {problem(found, 'standard output with room for it', 'Write it elsewhere.')}", err=True)
        sys.exit(InfotrajError.exit_status)


def _no_escape_code_at_the_end() -> None:
    # Where colorama is installed numba starts it, and it would end every output to a terminal with an escape code.
    started = sys.modules.get("colorama.initialise")
    if started is not None:
        atexit.unregister(started.reset_all)


if __name__ == "__main__":
    main()
