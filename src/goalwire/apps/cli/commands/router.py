"""ros2 router: runs a Zenoh router until Ctrl-C, like rmw_zenoh's `rmw_zenohd`."""

from __future__ import annotations

import os
import signal
from argparse import ArgumentParser, Namespace
from threading import Event
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb
from goalwire.errors import SecurityError

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.environment import Chosen


LOOK_S = 1.0
"""Seconds between two checks of the keystore's files for changes."""


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        '--port', metavar='N', type=port_to_name, help='TCP port (default: GOALWIRE_ROUTER_PORT, or 7447)'
    )
    parser.add_argument(
        '-l',
        '--listen',
        metavar='ADDRESS',
        action='append',
        default=[],
        help='Where to listen (e.g. tcp/192.168.0.7:7447; default: every address); may be repeated',
    )
    parser.add_argument(
        '-e',
        '--connect',
        metavar='ADDRESS',
        action='append',
        default=[],
        help='Another router to connect to (e.g. tcp/robot.local:7447); may be repeated',
    )
    parser.add_argument(
        '--secure',
        action='store_true',
        help='Require an identity: with GOALWIRE_SECURITY links use TLS, and the policy is enforced',
    )


def _router(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.transport.zenoh.settings.environment import INSTALL_ECLIPSE, router_port

    try:
        from goalwire.transport.zenoh.router import router
    except ImportError as error:
        if error.name != 'zenoh':
            raise
        raise CommandError(
            Outcome.FAILED,
            "a router for a site is eclipse-zenoh's, which is not installed",
            f'run {INSTALL_ECLIPSE}; programs of one machine find each other without a router',
        ) from None
    port = arguments.port or router_port()
    ended = Event()
    outcome = Outcome.INTERRUPTED

    def on_signal(number: int, _frame: FrameType | None) -> None:
        nonlocal outcome
        outcome = Outcome.TERMINATED if number == signal.SIGTERM else Outcome.INTERRUPTED
        ended.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)
    identity = _choose_identity(arguments)
    while not ended.is_set():
        with router(port, arguments.listen, arguments.connect, identity) as zid:
            _tell(arguments, port, zid, output)
            _wait(ended, identity)
    return outcome


def _choose_identity(arguments: Namespace) -> Chosen | None:
    """Return the identity of the router. Raises CommandError if --secure is given without one."""
    from goalwire.security import is_asked_for
    from goalwire.security.environment import choose_identity

    identity = choose_identity() if is_asked_for() else None
    if arguments.secure and identity is None:
        raise CommandError(
            Outcome.USAGE,
            '--secure needs an identity for the router',
            'set GOALWIRE_SECURITY=DIR:NAME; see: goalwire secure add NAME --router',
        )
    return identity


def _wait(ended: Event, identity: Chosen | None) -> None:
    """Wait until the router ends or the rules change, because Zenoh reads the rules only at the start."""
    if identity is None:
        ended.wait()
        return
    from goalwire.security.file_changes import look_at
    from goalwire.security.policy_file import load_policy
    from goalwire.security.revocation import load_revocations

    policy = identity.folder / 'policy.toml'
    files = (policy, identity.folder / 'revoked.toml', identity.identity_path)
    seen = look_at(files)
    while not ended.wait(LOOK_S):
        now = look_at(files)
        if now != seen:
            seen = now
            try:
                load_policy(policy)
                load_revocations(files[1])
            except SecurityError as error:
                tell(f'the keystore has changed, and the old one holds on: {error}')
                continue
            tell('the keystore has changed: the router starts anew')
            return


def _tell(arguments: Namespace, port: int, zid: str, output: Output) -> None:
    settings = os.environ.get('ZENOH_ROUTER_CONFIG_URI')
    of_settings = f'the addresses that {settings} names' if settings else f'port {port} of every address'
    where = ', '.join(arguments.listen) or of_settings
    if output.json:
        output.data({'id': zid, 'port': port, 'listen': arguments.listen})
    else:
        output.block(f'router {zid} listens on {where}; Ctrl-C ends it')


_SUMMARY = 'Run a Zenoh router for a site'
NOUN = Noun('router', _SUMMARY, (Verb('router', _SUMMARY, _router, _arguments),))
