"""Arguments by which the verbs of `bag` choose the bag, and topics of it."""

from __future__ import annotations

import re
from argparse import ArgumentParser, ArgumentTypeError, Namespace, _ArgumentGroup
from collections.abc import Iterable

from goalwire.apps.cli.framework.lookup import full_name
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import STORAGES


def bag_argument(parser: ArgumentParser) -> None:
    """Add the argument for the bag, and the flag that names the bag's storage format."""
    parser.add_argument('bag_path', help='Bag to open: a folder, or one file of it')
    storage_argument(parser)


def bags_argument(parser: ArgumentParser) -> None:
    """Add the argument for one or several bags, and the flag that names their storage format."""
    parser.add_argument('bag_path', nargs='+', help='Bag to open: a folder, or one file of it')
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


def open_bag(arguments: Namespace, path: str = '') -> Reader:
    """Open the named bag, or the one at `path`; raises CommandError if its storage format is not the
    requested one.
    """
    path = path or arguments.bag_path
    bag = Reader(path)
    if arguments.storage and bag.facts.storage != arguments.storage:
        found = bag.facts.storage
        bag.close()
        raise CommandError(
            Outcome.BAD_VALUE,
            f"the storage of '{path}' is {found}, not {arguments.storage}",
            'leave --storage out',
        )
    return bag


def names(given: Iterable[str], what: str) -> frozenset[str]:
    """Return full names; raises CommandError for an invalid name."""
    return frozenset(full_name(name, what) for name in given)


def regular_expression(text: str) -> str:
    """Read a regular expression."""
    try:
        re.compile(text)
    except re.error as error:
        raise ArgumentTypeError(f"'{text}' is not a regular expression: {error}") from None
    return text


def add_name_arguments(parser: ArgumentParser | _ArgumentGroup, verb: str, *, has_all: bool = False) -> None:
    """Add the flags that choose names; `verb` is what is done with them, for the help text."""
    for kind in ('topics', 'services', 'actions'):
        if has_all:
            parser.add_argument(f'--all-{kind}', action='store_true', help=f'{verb} all {kind}')
        parser.add_argument(f'--{kind}', metavar='NAME', nargs='+', default=[], help=f'{verb} these {kind}')
        parser.add_argument(
            f'--exclude-{kind}', metavar='NAME', nargs='+', default=[], help=f'Leave these {kind} out'
        )


def add_regex_arguments(parser: ArgumentParser | _ArgumentGroup, verb: str) -> None:
    """Add --regex and --exclude-regex."""
    for flags, text in (
        (('-e', '--regex'), f'{verb} names that contain this'),
        (('-x', '--exclude-regex'), 'Leave names out that contain this'),
    ):
        parser.add_argument(*flags, metavar='REGEX', type=regular_expression, default='', help=text)
