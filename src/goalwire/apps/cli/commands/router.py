"""ros2 router: a Zenoh router for a site, until Ctrl-C, as rmw_zenoh's `rmw_zenohd` is one."""

from __future__ import annotations

import signal
from argparse import ArgumentParser, Namespace
from threading import Event
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.numbers import port_to_name
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.apps.cli.framework.output import Output


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
        help='Where to listen (e.g. tcp/192.168.0.7:7447); every address where left out; may be repeated',
    )
    parser.add_argument(
        '-e',
        '--connect',
        metavar='ADDRESS',
        action='append',
        default=[],
        help='Another router to connect to (e.g. tcp/robot.local:7447); may be repeated',
    )


def _router(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.transport.zenoh.router import router
    from goalwire.transport.zenoh.settings.environment import router_port

    port = arguments.port or router_port()
    ended = Event()
    outcome = Outcome.INTERRUPTED

    def on_signal(number: int, _frame: FrameType | None) -> None:
        nonlocal outcome
        outcome = Outcome.TERMINATED if number == signal.SIGTERM else Outcome.INTERRUPTED
        ended.set()

    with router(port, arguments.listen, arguments.connect) as zid:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, on_signal)
        where = ', '.join(arguments.listen) or f'port {port} of every address'
        if output.json:
            output.data({'id': zid, 'port': port, 'listen': arguments.listen})
        else:
            output.block(f'router {zid} listens on {where}; Ctrl-C ends it')
        ended.wait()
    return outcome


_SUMMARY = 'Run a Zenoh router for a site'
NOUN = Noun('router', _SUMMARY, (Verb('router', _SUMMARY, _router, _arguments),))
