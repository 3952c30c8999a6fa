"""goalwire bridge foxglove and rosbridge: serves clients of web sockets until Ctrl-C."""

from __future__ import annotations

import os
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import goalwire
from goalwire.apps.bridge.permissions import Patterns, Permissions, check_pattern
from goalwire.apps.bridge.settings import Settings
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.numbers import count, port, positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import Output
from goalwire.apps.cli.framework.serving import NOT_ENCRYPTED, add_access_options, read_access

if TYPE_CHECKING:
    from goalwire.apps.bridge.server import OpenSession

TOKEN = 'GOALWIRE_BRIDGE_TOKEN'  # noqa: S105 - the name of the variable
_LISTS = {
    'publish': 'Topics on which clients may publish',
    'subscribe': 'Topics to which clients may subscribe',
    'services': 'Services that clients may call, and serve',
    'actions': 'Actions to which clients may send goals, and that they may serve',
    'parameters': "Parameters that clients may read and set, as '/node:parameter'",
}
_LONGEST_CALL_S = 1_000_000


def add_options(parser: ArgumentParser, default_port: int) -> None:
    """Add the options that all bridges have."""
    parser.add_argument(
        '--port',
        metavar='N',
        type=port,
        default=default_port,
        help=f'TCP port ({default_port}); 0: any that is free',
    )
    add_access_options(parser, 'clients', TOKEN, 'wss')
    parser.add_argument(
        '--origin',
        metavar='SITE',
        action='append',
        default=[],
        help='Let pages of a site connect without a token (e.g. https://app.foxglove.dev); may be repeated',
    )
    for name, text in _LISTS.items():
        parser.add_argument(
            f'--{name}',
            metavar='PATTERN',
            action='append',
            default=[],
            help=f"{text} (a glob, or 're:' and a regular expression; all); may be repeated",
        )
    parser.add_argument('--read-only', action='store_true', help='Let clients only look')
    parser.add_argument(
        '--backlog',
        metavar='BYTES',
        type=count,
        default=10_000_000,
        help='Bytes that may wait for one client; beyond them the oldest messages are dropped (10000000)',
    )
    parser.add_argument(
        '--max-message-size',
        metavar='BYTES',
        type=count,
        default=64_000_000,
        help='The longest message that a client may send (64000000)',
    )
    parser.add_argument(
        '--max-clients', metavar='N', type=count, default=100, help='How many clients may be connected (100)'
    )
    parser.add_argument(
        '--call-timeout',
        metavar='S',
        type=_time,
        default=10.0,
        help='How long a service, or the acceptance of a goal, may take (10)',
    )
    parser.add_argument(
        '--use-sim-time',
        action='store_true',
        help="Use the time of /clock, for example for stamps that are 'now'",
    )
    parser.add_argument('--keep-goals', action='store_true', help='Let goals go on when their client is lost')


def _time(text: str) -> float:
    number = positive(text)
    if number > _LONGEST_CALL_S:
        raise ArgumentTypeError(f"'{text}' is too long: {_LONGEST_CALL_S} s at most")
    return number


def settings_of(arguments: Namespace) -> Settings:
    """Return the settings of the options. Raises CommandError."""
    access = read_access(arguments, TOKEN)
    publish, subscribe, services, actions, parameters = (
        _patterns(name, getattr(arguments, name)) for name in _LISTS
    )
    return Settings(
        arguments.port,
        access.host,
        access.token,
        access.tls_cert,
        access.tls_key,
        tuple(arguments.origin),
        Permissions(publish, subscribe, services, actions, parameters, arguments.read_only),
        arguments.backlog,
        arguments.max_message_size,
        arguments.max_clients,
        arguments.call_timeout,
        arguments.keep_goals,
    )


def _patterns(name: str, given: list[str]) -> Patterns:
    for each in given:
        try:
            check_pattern(each)
        except ValueError as error:
            raise CommandError(Outcome.BAD_VALUE, f'--{name}: {error}', 'mend it') from None
    return Patterns(f'--{name}', tuple(given))


@contextmanager
def _require_packages() -> Iterator[None]:
    """Import packages of the extra `bridge` in the block. Raises CommandError if one is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise CommandError(
            Outcome.NOT_FOUND,
            f"the bridge needs the package '{error.name}'",
            "install it: pip install 'goalwire[bridge]'",
        ) from None


def _serve(
    name: str,
    arguments: Namespace,
    output: Output,
    open_session: OpenSession,
    subprotocols: Sequence[str] = (),
) -> Outcome:
    """Serve clients until Ctrl-C."""
    with _require_packages():
        from goalwire.apps.bridge.server import serve_clients

    settings = settings_of(arguments)

    def ready(url: str) -> None:
        output.show({'url': url}, f'{name} is served at {url}; Ctrl-C ends it')
        if not output.json and not settings.is_loopback and not settings.tls_cert:
            output.line(NOT_ENCRYPTED)
        output.flush()

    async def run(node: goalwire.Node) -> None:
        await serve_clients(node, settings, open_session, ready, subprotocols)

    return live(run, f'{name}_{os.getpid()}', use_sim_time=arguments.use_sim_time)


def add_serve_foxglove_arguments(parser: ArgumentParser) -> None:
    """Add the options of `bridge foxglove`."""
    add_options(parser, 8765)


def serve_foxglove(arguments: Namespace, output: Output) -> Outcome:
    """Serve Foxglove and clients of its SDK."""
    with _require_packages():
        from goalwire.apps.bridge.foxglove.frames import SUBPROTOCOLS
        from goalwire.apps.bridge.foxglove.session import FoxgloveSession

    return _serve('foxglove', arguments, output, FoxgloveSession, SUBPROTOCOLS)


def add_serve_rosbridge_arguments(parser: ArgumentParser) -> None:
    """Add the options of `bridge rosbridge`."""
    add_options(parser, 9090)


def serve_rosbridge(arguments: Namespace, output: Output) -> Outcome:
    """Serve clients of the rosbridge protocol."""
    with _require_packages():
        import cbor2  # noqa: F401 - named here, since clients ask for it later
        import PIL  # noqa: F401

        from goalwire.apps.bridge.rosbridge.session import RosbridgeSession

    return _serve('rosbridge', arguments, output, RosbridgeSession)
