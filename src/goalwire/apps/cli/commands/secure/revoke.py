"""goalwire secure revoke: refuses the certificates of a name."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, open_keystore

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure revoke`."""
    parser.add_argument('name', metavar='NAME', help='The identity')
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Revoke the certificate."""
    keystore = open_keystore(arguments)
    until = keystore.revoke(arguments.name)
    if output.json:
        output.data({'name': arguments.name, 'revoked': until.isoformat()})
    else:
        output.line(
            f'{arguments.name} is revoked in {keystore.revoked_path}; copy that file to the other machines'
        )
