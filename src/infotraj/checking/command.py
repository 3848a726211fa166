"""`infotraj check`: does this log mean what it says?"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from infotraj.errors import InputError, UsageError, problem
from infotraj.options import Number, accept_option, say_next
from infotraj.progress import waiting
from infotraj.suggested import again, quoted
from infotraj.terminal import show
from infotraj.writing import whole

if TYPE_CHECKING:
    from infotraj.checking.whole import Check


@click.command("check")
@click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="LOG|FLIGHT...")
@click.option("--vehicle", type=click.Path(path_type=Path), help="Vehicle file (YAML): gravity, limits of the rotors.")
@click.option("--mapping", help="A shipped mapping's name or a mapping file; default: chosen by looking at the log.")
@click.option(
    "--set", "changes", multiple=True, metavar="CHANNEL.KEY=VALUE", help="Read a channel otherwise; repeatable."
)
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="The whole report, for programs.")
@click.option("--from", "start", type=Number(), help="First t to check, s.")
@click.option("--to", "stop", type=Number(), help="Where to stop, s.")
@accept_option
@click.option("--skip-rejected", is_flag=True, help="Exit status 0 although logs are rejected, where one is left.")
@click.option("-q", "--quiet", is_flag=True, help="Only outcomes, rejections, cuts and warnings.")
@click.option("-v", "--verbose", is_flag=True, help="Effect and remedy of the notes too.")
def check_command(
    logs: tuple[Path, ...],
    vehicle: Path | None,
    mapping: str | None,
    changes: tuple[str, ...],
    json_file: Path | None,
    start: float | None,
    stop: float | None,
    accept: tuple[str, ...],
    skip_rejected: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """Say of each log whether it means what it says: units, frames, clocks, gaps, dead streams, coverage.

    Exit status 3 where a log is rejected; all rejected ones are named.
    """
    if start is not None and stop is not None and stop <= start:
        raise UsageError(problem(f"--to {stop:g} is not after --from {start:g}", "--from below --to", "Swap them."))
    from infotraj.checking.across import lags_across
    from infotraj.checking.codes import known, unmet
    from infotraj.checking.logs import check_logs
    from infotraj.checking.report import across_text, as_json, as_text
    from infotraj.importing import parse_settings
    from infotraj.importing.mapping_files import mapping_files
    from infotraj.importing.opening import log_files
    from infotraj.outputs import require_outputs
    from infotraj.vehicle import load_vehicle

    inputs = {
        "a log that is read": [p for log in logs for p in log_files(log)],
        "the vehicle file": [vehicle] if vehicle is not None else [],
        "a mapping that is read": mapping_files(mapping) if mapping is not None else [],
    }
    require_outputs({"--json": json_file}, {}, inputs)
    accepted = known(accept)
    believed = load_vehicle(vehicle) if vehicle is not None else None
    checks = []
    with waiting("checking"):
        found = check_logs(logs, mapping, believed, start, stop, settings=parse_settings(changes), accept=accepted)
    for check in found:
        checks.append(check)
        show(as_text(check, notes=not quiet, details=verbose))
    together = across_text(checks, accepted)
    if together:
        show(together)
    if json_file is not None:
        _write(json_file, json.dumps(as_json(checks, accepted), indent=1, allow_nan=False))
    rejected = [c for c in checks if c.outcome == "rejected"]
    kept = [c.source for c in checks if c.outcome != "rejected"]
    for c in rejected:
        click.echo(f"rejected: {c.source} ({c.findings[0].code})", err=True)
    for line in unmet(accepted, [f.code for c in checks for f in c.findings] + [f.code for f in lags_across(checks)]):
        click.echo(line, err=True)
    for line in _next(kept, rejected, mapping, changes, vehicle):
        say_next(line)
    if rejected and not (skip_rejected and kept):
        sys.exit(InputError.exit_status)


def _next(
    kept: list[str],
    rejected: list[Check],
    mapping: str | None,
    changes: tuple[str, ...] = (),
    vehicle: Path | None = None,
) -> list[str]:
    from infotraj.checking.settings import mended_by_fix

    read = (f" --mapping {quoted(mapping)}" if mapping else "") + "".join(f" --set {quoted(c)}" for c in changes)
    if not kept:
        first = next((c for c in rejected if c.findings[0].code != "unreadable"), None)
        if first is None:
            return []
        reading = f"infotraj import {quoted(first.source)}{read}"
        if mended_by_fix(first.findings[0]):
            return [f"{reading} --fix -o NEW.parquet"]
        return [f"{reading} --explain, to see what was taken for what"]
    flights = [k for k in kept if k.endswith((".parquet", ".csv")) and mapping is None and not changes]
    named = quoted(*kept)
    if len(flights) == len(kept):
        return [f"infotraj compare {quoted(vehicle or 'MODEL')} {named}{again('compare')}"]
    return [f"infotraj import {named}{read} -o flights/"]


def _write(path: Path, text: str) -> None:
    with whole(path) as part:
        part.write_text(text + "\n")
