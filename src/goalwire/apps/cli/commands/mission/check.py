"""goalwire mission check: replays a file's missions against their journals, before the file is deployed."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.definitions import missions_in
from goalwire.apps.cli.commands.mission.journals import add_journal_argument, open_journal
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission check`."""
    add_journal_argument(parser)
    parser.add_argument('file', metavar='FILE', help='The Python file with the missions')


def run(arguments: Namespace, output: Output) -> None:
    """Print for each open mission whether the file's code fits; raises CommandError if one does not."""
    from goalwire.missions.dry_replay import why_stuck

    definitions = missions_in(arguments.file)
    stuck = 0
    with open_journal(arguments) as store:
        for row in store.missions():
            if not row.state.is_open:
                continue
            definition = definitions.get(row.name)
            if definition is None:
                why = f"the file has no mission '{row.name}'"
            else:
                why = asyncio.run(why_stuck(row, definition, store.entries(row.id)))
            stuck += bool(why)
            output.show(
                {'id': row.id, 'fits': not why, 'why': why}, f'{row.id}: {f"stuck: {why}" if why else "fits"}'
            )
    if stuck:
        see = 'let the old code finish them, or cancel them'
        raise CommandError(Outcome.FAILED, f'{stuck} open missions do not fit this code', see)
