"""`infotraj examples`: the shipped flights and vehicle files, copied to where they can be tried."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import click

from infotraj.errors import InfotrajError, UsageError, problem
from infotraj.examples.location import FOLDERS, shipped
from infotraj.options import quiet_option, say_next
from infotraj.suggested import quoted


@click.command("examples")
@click.argument("folder", type=click.Path(path_type=Path))
@quiet_option
def examples_command(folder: Path, quiet: bool) -> None:
    """Copy example flights (FOLDER/quad) and vehicle files (FOLDER/vehicles).

    What is there already is never overwritten; the other one is copied, as into a checkout, which has the flights.
    """
    there = [name for name in FOLDERS if (folder / name).exists()]
    if len(there) == len(FOLDERS):
        raise UsageError(problem(f"{folder / there[0]} is there already", "a new place", "Name another folder."))
    for name in there:
        if not quiet:
            click.echo(f"{folder / name}: is there already, left as it is", err=True)
    for name in [name for name in FOLDERS if name not in there]:
        part = folder / f".{name}.part"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copytree(shipped(name), part, ignore=shutil.ignore_patterns("__pycache__"))
            os.replace(part, folder / name)
        except OSError as error:
            what = f"{folder / name}: {error.strerror or error}"
            raise InfotrajError(problem(what, "a place that can be written", "Choose another.")) from error
        finally:
            shutil.rmtree(part, ignore_errors=True)
        if not quiet:
            click.echo(
                f"{folder / name}: {len([p for p in (folder / name).rglob('*') if p.is_file()])} files", err=True
            )
    quad = folder / "quad"
    say_next(f"infotraj diagnose {quoted(quad / 'vehicle.yaml')} {quoted(quad)}/*.parquet")
