"""Shared by `fleet init` and `fleet join`: the identity, the addresses, and the file that is written."""

from __future__ import annotations

import json
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, find_folder, open_keystore
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.security.environment import Chosen

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.keystore import Keystore
    from goalwire.transport.zenoh.settings.values import Settings

PORT = 7447


def address(text: str) -> str:
    """Read the address of a router: HOST, HOST:PORT or tls/HOST:PORT. Raises ArgumentTypeError."""
    kind, slash, place = text.rpartition('/')
    if (slash and kind != 'tls') or not place or ' ' in place:
        raise ArgumentTypeError(f"'{text}' is not the address of a router: write HOST or HOST:PORT")
    has_port = ':' in place.rpartition(']')[2]
    return f'tls/{place}' if has_port else f'tls/{place}:{PORT}'


def add_writing_arguments(parser: ArgumentParser) -> None:
    """Add the arguments for the identity, its keystore, and the file of its settings."""
    parser.add_argument('name', metavar='NAME', help='The identity in the keystore')
    add_keystore_argument(parser)
    parser.add_argument(
        '--keys-there',
        metavar='DIR',
        type=Path,
        help="The keystore's folder on the machine that gets the settings (default: the same as here)",
    )
    parser.add_argument(
        '-o', '--output', metavar='FILE', type=Path, help='The file to write (default: NAME.json5)'
    )
    parser.add_argument('--force', action='store_true', help='Replace the file if it is there')


def open_identity(arguments: Namespace) -> tuple[Keystore, str, Chosen]:
    """Return the keystore, the kind of the identity, and the identity with its folder on its own machine.

    Raises CommandError, SecurityError.
    """
    from goalwire.security.certificates import kind_of

    keystore = open_keystore(arguments)
    kind = kind_of(keystore.identity(arguments.name).certificate)
    there = arguments.keys_there or find_folder(arguments).resolve()
    return keystore, kind, Chosen(there, arguments.name)


def write_settings(arguments: Namespace, settings: Settings, start: str, output: Output) -> Outcome:
    """Write the settings to a file, and print `start`, which tells how to use them. Raises CommandError.

    {file} in `start` stands for the path of the file.
    """
    path: Path = arguments.output or Path(f'{arguments.name}.json5')
    try:
        with path.open('w' if arguments.force else 'x', encoding='utf-8') as file:
            file.write(json.dumps(settings, indent=2) + '\n')
    except FileExistsError:
        raise CommandError(
            Outcome.REFUSED, f"the file '{path}' is there already", 'replace it with --force'
        ) from None
    except OSError as error:
        raise CommandError(Outcome.FAILED, f"'{path}' cannot be written: {error.strerror}") from None
    next_step = start.format(file=path)
    output.data({'file': str(path), 'next': next_step}) if output.json else output.line(
        f'{path} is written; next: {next_step}'
    )
    return Outcome.OK
