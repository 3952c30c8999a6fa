"""goalwire secure renew: gives identities new keys and certificates."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import (
    add_keystore_argument,
    add_life_argument,
    open_keystore,
)
from goalwire.apps.cli.commands.secure.showing import show_issued

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure renew`."""
    parser.add_argument('names', metavar='NAME', nargs='*', help='Identities (default: all of the keystore)')
    add_life_argument(parser)
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Renew the named identities, or all of the keystore, one after the other."""
    keystore = open_keystore(arguments)
    for name in arguments.names or keystore.names():
        show_issued(name, keystore.renew(name, arguments.days), output)
