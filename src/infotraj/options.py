"""Options that several commands take. Nothing heavy is imported here, so that a command loads at once."""

from typing import Any

import click


class Several(click.Option):
    """An option that takes all arguments up to the next option: `--reference a b c`; it may stand repeatedly, too."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, multiple=True, **kwargs)

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        super().add_to_parser(parser, ctx)
        for name in self.opts:
            option = parser._long_opt.get(name)
            if option is not None:
                option.process = _taking_all(option.process)


def _taking_all(process: Any) -> Any:
    def more(value: Any, state: Any) -> None:
        process(value, state)
        while state.rargs and not state.rargs[0].startswith("-"):
            process(state.rargs.pop(0), state)

    return more


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
