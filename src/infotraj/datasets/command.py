"""`infotraj data`: public data sets, listed and fetched."""

from __future__ import annotations

import json
from pathlib import Path

import click

from infotraj import __version__
from infotraj.datasets.fetch import DATA_SETS, default_root, entries, fetch, present
from infotraj.options import quiet_option, say_next
from infotraj.outputs import require_outputs
from infotraj.suggested import quoted
from infotraj.terminal import show
from infotraj.writing import whole


@click.group("data")
def data_command() -> None:
    """Public data sets (never part of the project)."""


@data_command.command("list")
@click.option("--dir", "root", type=click.Path(path_type=Path), help="Folder of the data sets; default: INFOTRAJ_DATA.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="The same, for programs.")
def list_command(root: Path | None, json_file: Path | None) -> None:
    """What can be fetched, and what is here."""
    root = root or default_root()
    require_outputs({"--json": json_file}, {}, {})
    rows = []
    for data_set in DATA_SETS.values():
        wanted = entries(data_set.name)
        here = [e.flight for e in wanted if present(e, root / data_set.name) is not None]
        rows.append({"name": data_set.name, "files": len(wanted), "here": len(here), "folder": str(root)})
        show(f"{data_set.name}: {data_set.what}")
        show(f"  {len(here)} of {len(wanted)} files in {root / data_set.name}; licence {data_set.licence}")
        show(f"  source: github.com/{data_set.repository} at {data_set.commit[:12]}")
    if json_file is not None:
        with whole(json_file) as part:
            part.write_text(json.dumps({"infotraj": __version__, "data_sets": rows}, indent=2) + "\n")


@data_command.command("get")
@click.argument("names", nargs=-1, required=True, metavar="NAME...")
@click.option("--dir", "root", type=click.Path(path_type=Path), help="Folder of the data sets; default: INFOTRAJ_DATA.")
@quiet_option
def get_command(names: tuple[str, ...], root: Path | None, quiet: bool) -> None:
    """Fetch data sets into FOLDER/NAME; files that are there and right are kept."""
    for name in names:
        entries(name)  # an unknown name is an error before anything is fetched
    for name in names:
        folder, fetched = fetch(name, root or default_root())
        if not quiet:
            click.echo(f"{folder}: {fetched} fetched, {len(entries(name)) - fetched} were there", err=True)
        say_next(f"infotraj check {quoted(folder)}/*")
