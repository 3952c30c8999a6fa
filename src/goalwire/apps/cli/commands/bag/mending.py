"""ros2 bag check, reindex and repair: what is wrong with a bag, and what can be saved of it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.bag.rewriting import reindex, repair
from goalwire.apps.cli.commands.bag.choosing import bag_argument, open_bag
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.rosbag2.reader import Reader, stored_files
from goalwire.rosbag2.writer import Writer

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag check` and `bag reindex`."""
    bag_argument(parser)


def check_bag(arguments: Namespace, output: Output) -> None:
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


def reindex_bag(arguments: Namespace, output: Output) -> None:
    """Write the metadata, and print the bag's content."""
    with reindex(arguments.bag_path) as bag:
        for problem in bag.problems:
            tell(problem)
        output.line(f'{bag.facts.count:,} messages in {len(bag.facts.files)} files')


def add_repair_bag_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag repair`."""
    add_arguments(parser)
    parser.add_argument('-o', '--output', metavar='FOLDER', required=True, help='Folder to make')


def repair_bag(arguments: Namespace, output: Output) -> None:
    """Write the new bag; the old one stays as it is."""
    path = arguments.bag_path
    # The files are listed from the folder, because the metadata may be broken.
    files = stored_files(path) if Path(path).is_dir() else ()
    with Reader(path, files=files) as bag, Writer(arguments.output, storage=bag.facts.storage) as target:
        for problem in bag.check():
            tell(problem)
        count = repair(bag, target)
        output.line(f"'{target.path}' has the {count:,} messages that can be read")
