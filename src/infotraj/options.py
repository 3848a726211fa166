"""Options that several commands take. Nothing heavy is imported here, so that a command loads at once."""

import click

command_steps_option = click.option(
    "--command-steps",
    type=click.IntRange(min=1),
    help="Steps that commands made from a row that holds them to the next; 1: held. Default: the metadata's.",
)
accept_option = click.option(
    "--accept",
    multiple=True,
    metavar="CODE[,CODE]",
    help="Findings that are shown and kept with the answer, and are in no one's way; may stand repeatedly.",
)
