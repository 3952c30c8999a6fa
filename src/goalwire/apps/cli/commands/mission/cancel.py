"""goalwire mission cancel: stops a mission; its goal is cancelled, and what it did is undone."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import (
    add_mission_arguments,
    find_mission,
    leave_command,
    open_journal,
)

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission cancel`."""
    add_mission_arguments(parser)
    parser.add_argument('--no-undo', action='store_true', help='Run no undo steps')


def run(arguments: Namespace, _output: Output) -> None:
    """Leave the command for the runner; raises CommandError."""
    with open_journal(arguments) as store:
        row = find_mission(store, arguments.mission_id)
        leave_command(store, row, 'cancel', {'undo': not arguments.no_undo})
