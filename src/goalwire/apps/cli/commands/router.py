"""ros2 router: runs a Zenoh router until Ctrl-C, like rmw_zenoh's `rmw_zenohd`."""

from __future__ import annotations

import os
import signal
from argparse import ArgumentParser, Namespace
from threading import Event
from time import monotonic
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.cli.framework.verbs import Noun, Verb
from goalwire.errors import AddressTakenError, SecurityError

if TYPE_CHECKING:
    from pathlib import Path
    from types import FrameType

    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.environment import Chosen


LOOK_S = 1.0
"""Seconds between two checks of the keystore's files for changes."""

RETURN_S = 10.0
"""How long a router that starts anew waits for its port. A program that started in that moment may have
taken the port, as the first program of a machine does. Most such programs are commands, which end within
seconds."""

RETRY_S = 0.5
"""Seconds between two attempts to take the port back; each attempt that fails costs 20 KiB for ever."""


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
    recovery = _PortRecovery()
    while not ended.is_set():
        seen = _look(identity)  # before the router reads the files, so that no change is missed
        try:
            with router(port, arguments.listen, arguments.connect, identity) as zid:
                _tell(arguments, port, zid, output)
                _wait(ended, identity, seen)
        except AddressTakenError as error:
            recovery.tell_or_raise(error)
            ended.wait(RETRY_S)
        else:
            recovery.begin()
    return outcome


class _PortRecovery:
    """The attempts of a router that starts anew to take its port back. At its first start it has none."""

    def __init__(self) -> None:
        self._end = 0.0
        self._is_told = False

    def begin(self) -> None:
        """Allow attempts from now on until `RETURN_S` are over."""
        self._end = monotonic() + RETURN_S
        self._is_told = False

    def tell_or_raise(self, error: AddressTakenError) -> None:
        """Say once that the port is taken; raise the error if the time for attempts is over."""
        if monotonic() >= self._end:
            raise error
        if not self._is_told:
            self._is_told = True
            tell(f'{error}; the router tries again for {RETURN_S:.0f} s')


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


def _files_of(identity: Chosen) -> tuple[Path, Path, Path]:
    """Return the policy, the revocations and the certificate of an identity."""
    return identity.folder / 'policy.toml', identity.folder / 'revoked.toml', identity.identity_path


def _look(identity: Chosen | None) -> object:
    """Return a value that changes with the files of an identity; None without one."""
    if identity is None:
        return None
    from goalwire.security.file_changes import look_at

    return look_at(_files_of(identity))


def _wait(ended: Event, identity: Chosen | None, seen: object) -> None:
    """Wait until the router ends or the rules change, because Zenoh reads the rules only at the start.

    `seen` is how the files looked before the router read them.
    """
    if identity is None:
        ended.wait()
        return
    from goalwire.security.policy_file import load_policy
    from goalwire.security.revocation import load_revocations

    policy, revocations, _ = _files_of(identity)
    while not ended.wait(LOOK_S):
        now = _look(identity)
        if now != seen:
            seen = now
            try:
                load_policy(policy)
                load_revocations(revocations)
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
