"""Options that several commands take."""

import click

command_steps_option = click.option(
    "--command-steps",
    type=click.IntRange(min=1),
    help="Steps that commands made from a row that holds them to the next; 1: held. Default: the metadata's.",
)
