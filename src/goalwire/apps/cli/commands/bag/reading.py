"""Arguments and opening, for the verbs that read bags."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import STORAGES


def bag_argument(parser: ArgumentParser) -> None:
    """Add the argument for the bag, and the flag that names the bag's storage format."""
    parser.add_argument('bag_path', help='Bag to open: a folder, or one file of it')
    storage_argument(parser)


def storage_argument(parser: ArgumentParser) -> None:
    """Add the flag that names the storage of a bag that is read."""
    parser.add_argument(
        '-s',
        '--storage',
        choices=['', *STORAGES],
        default='',
        help='Accepted as in ROS 2: the format is read from the files',
    )


def open_bag(arguments: Namespace) -> Reader:
    """Open the named bag; raises CommandError if its storage format is not the requested one."""
    bag = Reader(arguments.bag_path)
    if arguments.storage and bag.facts.storage != arguments.storage:
        found = bag.facts.storage
        bag.close()
        raise CommandError(
            Outcome.BAD_VALUE,
            f"the storage of '{arguments.bag_path}' is {found}, not {arguments.storage}",
            'leave --storage out',
        )
    return bag
