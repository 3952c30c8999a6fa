"""goalwire mission history: the journal of a mission, entry by entry."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import add_mission_arguments, find_mission, open_journal

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission history`."""
    add_mission_arguments(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Print the entries in the order in which they were written; raises CommandError."""
    from goalwire.apps.cli.commands.mission.showing import show_entry

    with open_journal(arguments) as store:
        for entry in store.entries(find_mission(store, arguments.mission_id).id):
            show_entry(entry, output)
