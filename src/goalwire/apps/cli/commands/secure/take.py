"""goalwire secure import: takes an identity from a file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import require_cryptography

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure import`."""
    parser.add_argument('file', metavar='FILE', type=Path, help="The file that 'secure export' has written")
    parser.add_argument(
        'folder', metavar='DIR', type=Path, help='The keystore on this machine; made if it does not exist'
    )


def run(arguments: Namespace, output: Output) -> None:
    """Import the archive."""
    require_cryptography()
    from goalwire.security.bundle import import_identity

    name = import_identity(arguments.folder, arguments.file)
    if output.json:
        output.data({'name': name, 'keystore': str(arguments.folder)})
    else:
        output.line(
            f'{name} is in {arguments.folder}; next: export GOALWIRE_SECURITY={arguments.folder}:{name}'
        )
