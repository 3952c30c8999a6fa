"""goalwire mission decide: tells the runner whether an uncertain step has happened."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.mission.journals import add_mission_arguments, answer

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `mission decide`."""
    add_mission_arguments(parser)
    parser.add_argument(
        'answer',
        choices=('done', 'again', 'fail'),
        help='done: it happened, go on; again: do it again; fail: it failed, and undo steps may run',
    )


def run(arguments: Namespace, _output: Output) -> None:
    """Leave the decision for the runner; raises CommandError."""
    answer(arguments, 'decide')
