"""`infotraj import`: logs to flight tables."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import click
import yaml

from infotraj.errors import InfotrajError, InputError, UsageError, problem


@click.command("import")
@click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="LOG...")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="NAME.parquet or NAME.csv; a folder for several.")
@click.option("--mapping", help="A shipped mapping's name or a mapping file; default: chosen by looking at the log.")
@click.option("--explain", is_flag=True, help="Print what was recognised and what is missing; writes only with -o.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="The same, for programs.")
@click.option("--save-mapping", type=click.Path(path_type=Path), help="Write the mapping that was used, to be edited.")
@click.option("--from", "start", type=float, help="First t to keep, s.")
@click.option("--to", "stop", type=float, help="Where to stop, s.")
@click.option("--rows", help="A channel whose samples make the rows, or a rate in Hz.")
@click.option(
    "--definitions",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Message definitions: a .msg file or a folder.",
)
@click.option("--allow-damaged", is_flag=True, help="Import what is left of a truncated or damaged log.")
@click.option("--skip-rejected", is_flag=True, help="Go on with the other logs; exit status 0 where one was imported.")
@click.option("-q", "--quiet", is_flag=True, help="No messages.")
@click.option("-v", "--verbose", is_flag=True, help="Print the table's metadata.")
def import_command(
    logs: tuple[Path, ...],
    output: Path | None,
    mapping: str | None,
    explain: bool,
    json_file: Path | None,
    save_mapping: Path | None,
    start: float | None,
    stop: float | None,
    rows: str | None,
    definitions: tuple[Path, ...],
    allow_damaged: bool,
    skip_rejected: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """Turn LOG (ROS 1 or 2 bag, MCAP, ULog, Crazyflie, CSV, Parquet) into a flight table."""
    targets = _targets(logs, output, explain)
    if start is not None and stop is not None and stop <= start:
        raise UsageError(problem(f"--to {stop:g} is not after --from {start:g}", "--from below --to", "Swap them."))
    _require_rows(rows)
    from infotraj.importing.explain import explain as explained
    from infotraj.importing.explain import inventory, missing_channels
    from infotraj.importing.importer import import_log
    from infotraj.importing.mapping_files import load_mapping

    chosen = load_mapping(mapping) if mapping is not None else None
    report: dict[str, Any] = {"flights": [], "rejected": []}
    for log, target in zip(logs, targets, strict=True):
        try:
            flight = import_log(
                log,
                chosen,
                start=start,
                stop=stop,
                definitions=definitions,
                allow_damaged=allow_damaged,
                rows=rows,
            )
        except InputError as error:
            report["rejected"].append({"path": str(log), "reason": str(error)})
            click.echo(f"rejected: {error}", err=True)
            if explain:
                _print_inventory(inventory, log, definitions, allow_damaged)
            continue
        if target is not None:
            _write(flight, target)
        if save_mapping is not None:
            _save_mapping(flight.meta["mapping"] if chosen is None else chosen, save_mapping)
        report["flights"].append(
            {
                "path": str(log),
                "output": str(target) if target else None,
                "rows": len(flight.table),
                "columns": list(map(str, flight.table.columns)),
                "missing": missing_channels(flight),
                **{k: v for k, v in flight.meta.items() if k != "source"},
            }
        )
        if explain:
            click.echo(explained(flight))
        if verbose:
            click.echo(yaml.safe_dump(flight.meta, sort_keys=False), err=True)
        if target is not None and not quiet:
            for note in flight.meta["notes"] if not explain else ():
                click.echo(f"note: {note}", err=True)
            click.echo(f"{target}: {len(flight.table)} rows by mapping {flight.meta['mapping']}", err=True)
    if json_file is not None:
        _write_text(json_file, json.dumps(report, indent=2))
    written = [f["output"] for f in report["flights"] if f["output"]]
    if written and not quiet:
        click.echo(f"next: infotraj check {' '.join(written)}", err=True)
    if report["rejected"] and not (skip_rejected and report["flights"]):
        sys.exit(InputError.exit_status)


def _targets(logs: tuple[Path, ...], output: Path | None, explain: bool) -> list[Path | None]:
    if output is None:
        if not explain:
            raise UsageError(problem("no -o", "-o flight.parquet, or --explain", "Say where the table goes."))
        return [None] * len(logs)
    if len(logs) == 1 and not output.is_dir():
        if output.suffix not in (".parquet", ".csv"):
            raise UsageError(problem(f"-o {output}", "a name that ends in .parquet or .csv", "Rename it."))
        if output.exists() and logs[0].exists() and output.samefile(logs[0]):
            raise UsageError(problem(f"-o {output} is the log itself", "another name", "Choose one."))
        return [output]
    if output.suffix in (".parquet", ".csv"):
        raise UsageError(problem(f"-o {output} for {len(logs)} logs", "a folder", "Give a folder's name."))
    targets = [output / f"{log.stem if log.is_file() else log.name}.parquet" for log in logs]
    twice = sorted({str(t) for t in targets if targets.count(t) > 1})
    if twice:
        raise UsageError(problem(f"two logs would become {twice[0]}", "logs of different names", "Import them apart."))
    return list(targets)


def _require_rows(rows: str | None) -> None:
    from infotraj.importing.channels import CHANNELS

    if rows is None or rows in CHANNELS:
        return
    try:
        good = 0.0 < float(rows) <= 1e5
    except ValueError:
        good = False
    if not good:
        raise UsageError(problem(f"--rows {rows}", f"Hz, or one of {', '.join(CHANNELS)}", "Correct it."))


def _print_inventory(inventory: Any, log: Path, definitions: tuple[Path, ...], allow_damaged: bool) -> None:
    try:
        click.echo(inventory(log, definitions, allow_damaged))
    except InputError:
        return  # the line that rejects the log has said why it cannot be opened


def _save_mapping(used: Any, path: Path) -> None:
    from infotraj.importing.mapping_files import load_mapping

    mapping = load_mapping(used) if isinstance(used, str) else used
    content = mapping.model_dump(mode="json", exclude_defaults=True)
    _write_text(path, yaml.safe_dump(content, sort_keys=False, width=110))


def _write(flight: Any, target: Path) -> None:
    try:
        flight.write(target)
    except OSError as error:
        raise InfotrajError(
            problem(f"{target}: {error.strerror}", "a place that can be written", "Choose another -o.")
        ) from error


def _write_text(path: Path, text: str) -> None:
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(text + ("" if text.endswith("\n") else "\n"))
        os.replace(part, path)
    except OSError as error:
        raise InfotrajError(
            problem(f"{path}: {error.strerror}", "a place that can be written", "Choose another.")
        ) from error
    finally:
        part.unlink(missing_ok=True)
