"""goalwire mission list: lists the missions of a journal file; no runner is needed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import add_journal_argument, open_journal

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission list`."""
    add_journal_argument(parser)
    parser.add_argument('--open', action='store_true', help='Only missions that have not ended')


def run(arguments: Namespace, output: Output) -> None:
    """Print the missions in the order in which they began; raises CommandError."""
    from goalwire.apps.cli.commands.mission.showing import clock_time, row_data, state_style

    with open_journal(arguments) as store:
        rows = [row for row in store.missions() if row.state.is_open or not arguments.open]
    for row in rows:
        if output.json:
            output.data(row_data(row))
            continue
        state = output.style(f'{row.state:10}', state_style(row.state))
        why = f'  {row.why}' if row.why else ''
        output.block(f'{row.id}  {state}  {row.name}  since {clock_time(row.begun)}{why}')
