"""goalwire secure export: writes an identity into one file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, open_keystore

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure export`."""
    parser.add_argument('name', metavar='NAME', help='The identity')
    parser.add_argument('file', metavar='FILE', nargs='?', type=Path, help='Default: NAME.identity')
    parser.add_argument(
        '--authority',
        metavar='URL',
        default='',
        help="Where its certificate is renewed: the address of 'secure authority' (e.g. https://192.168.0.7:7449)",
    )
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Write the archive."""
    keystore = open_keystore(arguments)
    from goalwire.security.bundle import export

    path = arguments.file or Path(f'{arguments.name}.identity')
    export(keystore, arguments.name, path, arguments.authority)
    if output.json:
        output.data({'name': arguments.name, 'file': str(path)})
    else:
        output.line(f'{path} holds the key of {arguments.name}: carry it there, and delete it here')
