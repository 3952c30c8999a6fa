"""goalwire secure init: makes a keystore."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import require_cryptography

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure init`."""
    parser.add_argument('folder', metavar='DIR', type=Path, help='A new or an empty folder')


def run(arguments: Namespace, output: Output) -> None:
    """Make the keystore."""
    require_cryptography()
    from goalwire.security.keystore import Keystore

    keystore = Keystore.create(arguments.folder)
    if output.json:
        output.data({'keystore': str(keystore.path)})
    else:
        output.line(
            f'keystore {keystore.path} is made; next: goalwire secure add NAME --robot -k {keystore.path}'
        )
