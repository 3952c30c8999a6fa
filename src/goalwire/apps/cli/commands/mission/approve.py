"""goalwire mission approve: answers the question that a mission asks by `m.approve`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import add_mission_arguments, answer

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission approve`."""
    add_mission_arguments(parser)
    parser.add_argument(
        'answer', nargs='?', choices=('yes', 'no'), default='yes', help='The answer (default: yes)'
    )


def run(arguments: Namespace, _output: Output) -> None:
    """Leave the answer for the runner; raises CommandError."""
    answer(arguments, 'approve')
