"""goalwire secure issue: makes a key and a certificate for a name that has none."""

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
    """Add the arguments of `secure issue`."""
    parser.add_argument('name', metavar='NAME', help='An identity that policy.toml names')
    add_kind_arguments(parser)
    add_life_argument(parser)
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Issue the certificate."""
    made = open_keystore(arguments).issue(arguments.name, arguments.kind, arguments.days)
    show_issued(arguments.name, made, output)
