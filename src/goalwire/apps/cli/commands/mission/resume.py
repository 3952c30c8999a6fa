"""goalwire mission resume: continues a mission that is paused, held after a restart, or stuck."""

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
    """Add the arguments of `mission resume`."""
    add_mission_arguments(parser)


def run(arguments: Namespace, _output: Output) -> None:
    """Leave the command for the runner; raises CommandError."""
    with open_journal(arguments) as store:
        leave_command(store, find_mission(store, arguments.mission_id), 'resume', {})
