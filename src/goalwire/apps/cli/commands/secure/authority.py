"""goalwire secure authority: renews certificates over the network, until Ctrl-C."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, Namespace
from threading import Thread
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, open_keystore
from goalwire.apps.cli.framework.live import until_signal
from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

_PORT = 7449


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure authority`."""
    parser.add_argument(
        '--port', metavar='N', type=port_to_name, default=_PORT, help=f'TCP port (default: {_PORT})'
    )
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Listen, and renew the certificates of those who ask."""
    keystore = open_keystore(arguments)
    from goalwire.security.authority import AuthorityServer

    try:
        server = AuthorityServer(keystore, arguments.port, tell)
    except OSError as error:
        raise CommandError(
            Outcome.UNAVAILABLE,
            f'port {arguments.port} cannot be used: {error.strerror}',
            'give another --port',
        ) from None
    thread = Thread(target=server.serve_forever, name='authority')
    thread.start()

    async def wait() -> None:
        if output.json:
            output.data({'keystore': str(keystore.path), 'port': arguments.port})
        else:
            output.block(f'the authority of {keystore.path} listens on port {arguments.port}; Ctrl-C ends it')
        await asyncio.Event().wait()

    try:
        return until_signal(wait)
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
