"""ros2 bag check: checks that a bag is complete and undamaged."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.bag.reading import bag_argument, open_bag
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag check`."""
    bag_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Print the faults of the bag; raises CommandError if there are any."""
    with open_bag(arguments) as bag:
        count = 0
        for count, problem in enumerate(bag.check(), 1):  # noqa: B007 - it is counted
            output.line(problem)
        if count:
            raise CommandError(
                Outcome.FAILED,
                f"'{bag.path}' is not whole",
                f'run: ros2 bag repair {bag.path} -o FOLDER',
            )
        output.line(f'{bag.facts.count:,} messages in {len(bag.facts.files)} files: every byte is there')
