"""`infotraj app`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("app")
@click.argument("folder", default=".", type=click.Path(path_type=Path), metavar="[DIR]")
@click.option("--port", type=click.IntRange(0, 65535), default=5006, show_default=True, help="0: any that is free.")
@click.option(
    "--upload-limit", type=click.IntRange(min=1), default=500, show_default=True, help="Of a log that is dropped, MB."
)
@click.option("--no-browser", is_flag=True, help="Do not open a browser.")
@click.option("-q", "--quiet", is_flag=True, help="No messages but the address.")
def app_command(folder: Path, port: int, upload_limit: int, no_browser: bool, quiet: bool) -> None:
    """Serve the flights and models of DIR as a page on 127.0.0.1: check, diagnose, tick effects, save the model.

    Nothing outside DIR is written, and no other machine can reach it. Ctrl-C ends it.
    """
    from infotraj.app.server import serve

    serve(folder, port=port, upload_limit=upload_limit * 1_000_000, browser=not no_browser, quiet=quiet)
