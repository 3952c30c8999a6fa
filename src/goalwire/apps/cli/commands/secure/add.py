"""goalwire secure add: makes an identity, and names it in the policy."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import (
    add_keystore_argument,
    add_kind_arguments,
    add_life_argument,
    open_keystore,
)
from goalwire.apps.cli.commands.secure.showing import show_issued

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure add`."""
    parser.add_argument('name', metavar='NAME', help="The identity's name, as policy.toml has it")
    add_kind_arguments(parser)
    parser.add_argument(
        '--role',
        action='append',
        default=[],
        metavar='ROLE',
        help='A role of policy.toml (default: robot for a robot, viewer for a person); may be repeated',
    )
    add_life_argument(parser)
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Make the identity."""
    keystore = open_keystore(arguments)
    made = keystore.add(arguments.name, arguments.kind, tuple(arguments.role), arguments.days)
    show_issued(arguments.name, made, output)
