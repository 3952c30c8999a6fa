"""goalwire fleet init: writes the settings of the router of a site or of a cloud.

They are those of Zenoh's router: `goalwire router` and eclipse's zenohd read them.
"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.fleet.writing import (
    PORT,
    add_writing_arguments,
    address,
    open_identity,
    write_settings,
)
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `fleet init`."""
    add_writing_arguments(parser)
    parser.add_argument(
        '--listen',
        metavar='ADDRESS',
        type=address,
        action='append',
        help=f'Where robots and operators come: HOST:PORT (default: port {PORT} of every address)',
    )
    parser.add_argument(
        '--router',
        metavar='ADDRESS',
        type=address,
        action='append',
        default=[],
        help='The router above, HOST or HOST:PORT: that of the cloud; a cloud has none',
    )


def run(arguments: Namespace, output: Output) -> Outcome:
    """Write the settings of a router, which list the robots and the other identities of the keystore."""
    from goalwire.security.certificates import kind_of
    from goalwire.transport.zenoh.settings import built_in, fleet

    keystore, kind, identity = open_identity(arguments)
    if kind != 'router':
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{arguments.name}' is a {kind}, and not a router",
            f'see: goalwire secure add NAME --router, or: goalwire fleet join {arguments.name}',
        )
    revoked = keystore.revoked()
    kinds = {name: kind_of(keystore.identity(name).certificate) for name in keystore.names()}
    there = {name: each for name, each in kinds.items() if name not in revoked and name != arguments.name}
    settings = fleet.site_router(
        identity,
        arguments.listen or [str(each) for each in built_in.everywhere(PORT)],
        arguments.router,
        [name for name, each in there.items() if each == 'robot'],
        [name for name, each in there.items() if each != 'robot'],
    )
    start = 'carry it to its machine, and run there: ZENOH_ROUTER_CONFIG_URI={file} goalwire router'
    return write_settings(arguments, settings, start, output)
