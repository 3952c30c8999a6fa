"""Running a command that takes part in the graph, and ending it with Ctrl-C."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Awaitable, Callable
from math import inf
from time import monotonic
from typing import TypeAlias

import goalwire
from goalwire.apps.cli.framework.discovery import MISSING_S, robots_there, unknown_robot
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.robots import find_robot
from goalwire.logging import get_logger
from goalwire.rules.names.robots import robot_of
from goalwire.transport.contract import EndpointKind

NODE_NAME_PREFIX = '_ros2cli'
"""The names of the commands' nodes begin with this, as in ROS 2; the underscore hides the nodes."""
_AT_ONCE = 3
"""After this many presses of Ctrl-C the process ends at once, without cleaning up."""
_WARN, _ERROR = 30, 40
_SAME_S = 0.2
"""Signals within this time count as one: `timeout` and supervisors signal the process and its group."""

Main: TypeAlias = Callable[['goalwire.Node'], Awaitable[Outcome | None]]


def live(main: Main, node_name: str | None = None, *, use_sim_time: bool = False) -> Outcome:
    """Run `main` with a node of the command's own, until it returns.

    If the user has chosen a robot, the node sees only that robot; raises CommandError if the robot has no
    node. Each Ctrl-C or SIGTERM cancels `main`. After the first signal `main` may clean up; a second one ends
    the clean-up.
    """

    robot = find_robot()

    async def run() -> Outcome | None:
        name = node_name or f'{NODE_NAME_PREFIX}_{os.getpid()}'
        clock = {'use_sim_time': use_sim_time}
        async with goalwire.Node(name, parameters=clock, robots=robot) as node:
            if robot and not await _is_there(node, robot):
                raise _NoRobot
            return await main(node)

    try:
        return until_signal(run)
    except _NoRobot:
        raise unknown_robot(robot, robots_there()) from None


class _NoRobot(Exception):
    """Ends a command whose robot has no node."""


async def _is_there(node: goalwire.Node, robot: str) -> bool:
    """Return whether a robot has a node, or gets one while it is being discovered."""

    def has_node() -> bool:
        return any(robot_of(name.rpartition('/')[0]) == robot for name in node.graph.nodes())

    changes = node.graph.changes()
    try:
        async with asyncio.timeout(MISSING_S):
            while not has_node():
                await anext(changes)
    except TimeoutError:
        return has_node()
    finally:
        changes.close()
    return True


def until_signal(main: Callable[[], Awaitable[Outcome | None]]) -> Outcome:
    """Run `main` until it returns; signals end it as `live` says."""
    signals: list[int] = []

    async def run() -> Outcome | None:
        _watch_signals(signals)
        return await main()

    try:
        outcome = asyncio.run(run())
    except (KeyboardInterrupt, asyncio.CancelledError):
        return Outcome.TERMINATED if signal.SIGTERM in signals else Outcome.INTERRUPTED
    sys.stdout.flush()
    return Outcome.OK if outcome is None else outcome


def _watch_signals(signals: list[int]) -> None:
    """Let signals cancel the current task; on platforms without signal handlers asyncio handles Ctrl-C."""
    task = asyncio.current_task()
    assert task is not None

    last = -inf

    def on_signal(number: int) -> None:
        nonlocal last
        if monotonic() - last < _SAME_S:
            return
        last = monotonic()
        signals.append(number)
        if len(signals) >= _AT_ONCE:
            os._exit(Outcome.INTERRUPTED)
        task.cancel()

    if sys.platform != 'win32':
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, on_signal, number)


def types_there(node: goalwire.Node, kind: EndpointKind, name: str) -> list[str]:
    """Return the types of a name's endpoints that the node has discovered by now."""
    return sorted({entity.type_name for entity in node.context.graph.entities(kind, name)})


def tell_types_ourselves() -> None:
    """Silence the library's warnings of types that do not match: the command reports them in its one line."""
    get_logger('goalwire').set_level(_ERROR)
    get_logger('goalwire.transport').set_level(_WARN)


def refuse_other_type(name: str, type_name: str, types: list[str]) -> None:
    """Raise CommandError if a name is in the graph, but only with other types."""
    if types and type_name not in types:
        raise CommandError(
            Outcome.BAD_VALUE,
            f"'{name}' has the type {', '.join(types)}, not {type_name}",
            'leave the type out',
        )
