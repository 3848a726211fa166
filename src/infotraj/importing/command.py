"""`infotraj import`: logs to flight tables."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import click
import yaml

from infotraj import __version__
from infotraj.errors import InputError, UsageError, problem
from infotraj.options import Number, quiet_option, say_next
from infotraj.progress import parts, waiting
from infotraj.suggested import quoted
from infotraj.terminal import show

# % of the time after opening, of logs of 20 to 540 MB that were read on 26 November 2026: messages are decoded one by
# one, rows of tables are not. Of blackbox and binary DataFlash logs nothing is counted while they are decoded.
_PARTS = {
    "messages": {"reading": 90.0, "streams": 5.0, "rows": 2.0, "checks": 3.0},
    "table": {"reading": 35.0, "streams": 30.0, "rows": 20.0, "checks": 15.0},
}


@click.command("import")
@click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="LOG...")
@click.option(
    "-o", "--output", "place", type=click.Path(), help="NAME.parquet, NAME.csv, or FOLDER/; for several FOLDER."
)
@click.option("--mapping", help="A shipped mapping's name or a mapping file; default: chosen by looking at the log.")
@click.option("--set", "changes", multiple=True, metavar="CHANNEL.KEY=VALUE", help="Replaces a mapping's key.")
@click.option("--fix", is_flag=True, help="Apply what `infotraj check` says would mend it; writes the mapping, too.")
@click.option(
    "--with", "beside", multiple=True, type=click.Path(path_type=Path), help="A further table of the same flight."
)
@click.option("--explain", is_flag=True, help="Print what was recognised and what is missing; writes only with -o.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="The same, for programs.")
@click.option(
    "--save-mapping",
    "mapping_file",
    type=click.Path(path_type=Path),
    help="Write the mapping that was used, to be edited.",
)
@click.option("--from", "start", type=Number(), help="First t to keep, s.")
@click.option("--to", "stop", type=Number(), help="Where to stop, s.")
@click.option("--rows", help="A channel whose samples make the rows, or a rate in Hz.")
@click.option(
    "--definitions",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Message definitions: a .msg file or a folder.",
)
@click.option("--allow-damaged", is_flag=True, help="Import what is left of a truncated or damaged log.")
@click.option("--skip-rejected", is_flag=True, help="Go on with the other logs; exit status 0 where one was imported.")
@quiet_option
@click.option("-v", "--verbose", is_flag=True, help="Print the table's metadata.")
def import_command(
    logs: tuple[Path, ...],
    place: str | None,
    mapping: str | None,
    beside: tuple[Path, ...],
    changes: tuple[str, ...],
    fix: bool,
    explain: bool,
    json_file: Path | None,
    mapping_file: Path | None,
    start: float | None,
    stop: float | None,
    rows: str | None,
    definitions: tuple[Path, ...],
    allow_damaged: bool,
    skip_rejected: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """Turn LOG (ROS 1 or 2 bag, MCAP, ULog, ArduPilot, blackbox, Crazyflie, CSV, Parquet) into a flight table."""
    targets = _targets(logs, place, explain)
    _require_fixable(logs, place, fix, mapping_file, allow_damaged or bool(beside))
    if beside and len(logs) > 1:
        raise UsageError(problem(f"--with for {len(logs)} logs", "one log", "Import them one by one."))
    if start is not None and stop is not None and stop <= start:
        raise UsageError(problem(f"--to {stop:g} is not after --from {start:g}", "--from below --to", "Swap them."))
    _require_rows(rows)
    from infotraj.flight import flight_files
    from infotraj.importing.explain import explain as explained
    from infotraj.importing.explain import inventory, missing_channels
    from infotraj.importing.importer import to_flight
    from infotraj.importing.mapping_files import load_mapping, mapping_files
    from infotraj.importing.opening import kind_of, log_files
    from infotraj.importing.reading import read_streams
    from infotraj.importing.saving import save_extension, save_mapping, write_text
    from infotraj.importing.settings import parse_settings
    from infotraj.outputs import require_outputs

    tables = [t for t in targets if t is not None]
    require_outputs(
        {
            "-o": [p for t in tables for p in flight_files(t)],
            "--save-mapping": mapping_file or (list(map(_beside, tables)) if fix else None),
            "--json": json_file,
        },
        {},
        {
            "a log that is read": [p for log in logs for p in log_files(log)],
            "a table that is read": [p for table in beside for p in flight_files(table)],
            "a mapping that is read": mapping_files(mapping) if mapping is not None else [],
            "a message definition that is read": [
                p for d in definitions for p in (d.rglob("*.msg") if d.is_dir() else [d])
            ],
        },
    )
    chosen = load_mapping(mapping) if mapping is not None else None
    settings = parse_settings(changes)
    report: dict[str, Any] = {"infotraj": __version__, "flights": [], "rejected": []}
    for number, (log, target) in enumerate(zip(logs, targets, strict=True), 1):
        own = settings
        try:
            named = f"{log.name}, {number} of {len(logs)}" if len(logs) > 1 else log.name
            if fix:
                own = _fixed(log, mapping, chosen, settings, start, stop, definitions, quiet)
            with waiting(f"importing {named}"):
                parts(_PARTS["table" if kind_of(log) == "table" else "messages"])
                read = read_streams(
                    log, chosen, definitions=definitions, allow_damaged=allow_damaged, settings=own, beside=beside
                )
                flight = to_flight(read, start=start, stop=stop, rows=rows)
        except InputError as error:
            report["rejected"].append({"path": str(log), "reason": str(error)})
            click.echo(f"rejected: {error}", err=True)
            if explain:
                _print_inventory(inventory, log, definitions, allow_damaged)
            continue
        if explain:
            show(explained(flight, read, definitions, allow_damaged))
        if target is not None:
            flight.write(target)
        if fix and target is not None:
            saved = mapping_file or _beside(target)
            save_extension(mapping or flight.meta["mapping"], own, saved)
            if not quiet:
                click.echo(f"{saved}: the mapping with these settings", err=True)
        elif mapping_file is not None:
            save_mapping(flight.meta["mapping"] if chosen is None else chosen, own, mapping_file)
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
        if verbose:
            click.echo(yaml.safe_dump(flight.meta, sort_keys=False), err=True)
        if target is not None and not quiet:
            for note in flight.meta["notes"] if not explain else ():
                click.echo(f"note: {note}", err=True)
            click.echo(f"{target}: {len(flight.table)} rows by mapping {flight.meta['mapping']}", err=True)
    if json_file is not None:
        write_text(json_file, json.dumps(report, indent=2))
    written = [f["output"] for f in report["flights"] if f["output"]]
    if written:
        say_next(f"infotraj check {quoted(*written)}")
    if report["rejected"] and not (skip_rejected and report["flights"]):
        sys.exit(InputError.exit_status)


def _targets(logs: tuple[Path, ...], place: str | None, explain: bool) -> list[Path | None]:
    if place is None:
        if not explain:
            raise UsageError(problem("no -o", "-o flight.parquet, or --explain", "Say where the table goes."))
        return [None] * len(logs)
    output = Path(place)
    folder = place.endswith(("/", os.sep)) or output.is_dir()
    named = output.suffix in (".parquet", ".csv")
    if len(logs) == 1 and not folder and not named:
        remedy = f"Rename it, or put a / behind a folder's name: -o {output}/"
        raise UsageError(problem(f"-o {output}", "a name that ends in .parquet or .csv, or a folder", remedy))
    if len(logs) > 1 and not folder and named:
        raise UsageError(problem(f"-o {output} for {len(logs)} logs", "a folder", "Give a folder's name."))
    several = folder or len(logs) > 1
    targets = [output / f"{log.stem if log.is_file() else log.name}.parquet" if several else output for log in logs]
    twice = sorted({str(t) for t in targets if targets.count(t) > 1})
    if twice:
        raise UsageError(problem(f"two logs would become {twice[0]}", "logs of different names", "Import them apart."))
    return list(targets)


def _beside(target: Path) -> Path:
    """Where --fix writes its mapping where no option says so."""
    return target.with_name(f"{target.stem}.mapping.yaml")


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
        show(inventory(log, definitions, allow_damaged))
    except InputError:
        return  # the line that rejects the log has said why it cannot be opened


def _require_fixable(
    logs: tuple[Path, ...], place: str | None, fix: bool, mapping_file: Path | None, read_otherwise: bool
) -> None:
    if not fix:
        return
    if place is None:
        raise UsageError(problem("--fix without -o", "-o flight.parquet", "Say where the table goes."))
    if read_otherwise:
        remedy = "Import first, then fix the table."
        raise UsageError(problem("--fix beside --allow-damaged or --with", "--fix without them", remedy))
    if mapping_file is not None and len(logs) > 1:
        raise UsageError(problem(f"one --save-mapping for {len(logs)} logs", "one log", "Leave it out: each gets one."))


def _fixed(
    log: Path,
    mapping: str | None,
    chosen: Any,
    settings: Any,
    start: float | None,
    stop: float | None,
    definitions: tuple[Path, ...],
    quiet: bool,
) -> Any:
    """The settings that mend the log, said line by line. InputError where `check` would reject it all the same."""
    from infotraj.checking.mending import mend
    from infotraj.importing.settings import settings_text

    with waiting(f"mending {log.name}"):
        mended = mend(log, chosen, settings, start, stop, definitions)
    if not quiet:
        for setting, code, what in mended.changed:
            click.echo(f"set {setting} ({code}: {what})", err=True)
        for finding in mended.left:
            click.echo(f"left: {finding.code}: {finding.what}", err=True)
        if not mended.changed:
            click.echo(f"{log}: nothing that a setting would mend", err=True)
    rejects = list(dict.fromkeys(f.code for f in mended.left if f.severity == "reject"))
    if rejects:
        read = f"--mapping {quoted(mapping)} " if mapping is not None else ""
        options = "".join(f"--set {quoted(s)} " for s in settings_text(mended.settings))
        raise InputError(
            problem(
                f"{log}: --fix leaves {', '.join(rejects)}",
                "a log that settings mend",
                f"See what is left: infotraj check {quoted(log)} {read}{options}".rstrip(),
            )
        )
    return mended.settings
