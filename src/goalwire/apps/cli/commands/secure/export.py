"""goalwire secure export: writes an identity into one file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, open_keystore

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.keystore import Keystore


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure export`."""
    parser.add_argument('name', metavar='NAME', help='The identity')
    parser.add_argument(
        'file',
        metavar='FILE',
        nargs='?',
        type=Path,
        help='Default: NAME.identity; a name that ends in .p12 is for browsers',
    )
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
    if path.suffix == '.p12':
        _export_for_browser(keystore, arguments.name, path, output)
        return
    export(keystore, arguments.name, path, arguments.authority)
    if output.json:
        output.data({'name': arguments.name, 'file': str(path)})
    else:
        output.line(f'{path} holds the key of {arguments.name}: carry it there, and delete it here')


def _export_for_browser(keystore: Keystore, name: str, path: Path, output: Output) -> None:
    """Write the certificate for a browser, and print the password that the browser asks for."""
    from goalwire.security.bundle import export_for_browser

    password = export_for_browser(keystore, name, path)
    if output.json:
        output.data({'name': name, 'file': str(path), 'password': password})
    else:
        output.line(f'{path} holds the key of {name}; the browser asks for its password: {password}')
