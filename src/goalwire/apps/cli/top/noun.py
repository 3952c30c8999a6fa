"""goalwire top: nodes, topics, services, goals and log lines on one screen, drawn by Textual."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from argparse import ArgumentParser, Namespace
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.action.display import check_field, progress_argument
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.cli.framework.output import Output
    from goalwire.apps.cli.top.app import Top

SUMMARY = 'Show nodes, topics, services, goals and log lines on one screen'
TIMEOUT_S = 10.0
_LOOK_S = 1.0
"""Seconds between two checks that the terminal is open: a terminal may close without a signal."""


def _arguments(parser: ArgumentParser) -> None:
    from goalwire.apps.cli.framework.numbers import timeout_argument

    parser.add_argument('-a', '--all', action='store_true', help='Show hidden names, too')
    progress_argument(parser, '. Without it, the name of a field tells the progress')
    timeout_argument(parser, TIMEOUT_S, 'Seconds that a call may take, and a goal until it is accepted')


def _top(arguments: Namespace, output: Output) -> Outcome:
    """Show the screen until the user leaves it."""
    try:
        import textual as _textual  # noqa: F401
    except ImportError:
        raise CommandError(
            Outcome.UNAVAILABLE,
            'top is drawn by Textual, which is not installed',
            "run: pip install 'goalwire[top]'",
        ) from None
    if not (output.is_terminal and sys.stdin.isatty()) or os.environ.get('TERM') == 'dumb':
        raise CommandError(
            Outcome.UNAVAILABLE,
            'top needs a terminal that it can draw on',
            'use: ros2 node list, topic hz, service list, action watch',
        )
    check_field(arguments.progress)
    from goalwire.apps.cli.framework.live import live

    return live(lambda node: _show(node, arguments))


async def _show(node: goalwire.Node, arguments: Namespace) -> Outcome:
    from goalwire.apps.cli.framework.live import tell_types_ourselves
    from goalwire.apps.cli.top.app import Options, Top

    tell_types_ourselves()
    options = Options(hidden=arguments.all, progress=arguments.progress, timeout=arguments.timeout)
    app = Top(node, options)
    try:
        return await _run(app, node)
    finally:
        goals = dict(app.own_goals)
        await app.close_data()
        if goals:
            from goalwire.apps.cli.framework.output import tell

            tell('\n'.join(f'the goal {goal_id} of {name} goes on' for goal_id, name in goals.items()))


async def _run(app: Top, node: goalwire.Node) -> Outcome:
    """Run the screen, and restore the terminal on every way out."""
    running = asyncio.create_task(app.run_async())
    hung_up = asyncio.create_task(_hang_up())
    try:
        await asyncio.wait({running, hung_up}, return_when=asyncio.FIRST_COMPLETED)
    except asyncio.CancelledError:  # cancelled by a signal
        app.exit()
        await running
        raise
    finally:
        hung_up.cancel()
    if not running.done():
        # The terminal was closed, so it is not restored: Textual would wait for it.
        await node.__aexit__(None, None, None)
        os._exit(Outcome.TERMINATED)
    if app.fault is not None:
        raise app.fault
    return (await running) or Outcome.OK


async def _hang_up() -> None:
    """Wait until the terminal is closed, with or without SIGHUP."""
    hung_up = asyncio.Event()
    if sys.platform != 'win32':
        asyncio.get_running_loop().add_signal_handler(signal.SIGHUP, hung_up.set)
    while os.isatty(sys.stdin.fileno()) and not hung_up.is_set():
        with suppress(TimeoutError):
            async with asyncio.timeout(_LOOK_S):
                await hung_up.wait()


NOUN = Noun('top', SUMMARY, (Verb('top', SUMMARY, _top, _arguments, has_json=False),))
