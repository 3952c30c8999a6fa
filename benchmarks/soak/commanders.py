"""Programs that command every server all the time, whatever that raises: SIGTERM ends them.

Each says in the end what became of the commands that it went on to give after the end of its context. Those
have negative numbers, so servers know them.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.msg import Int64
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.node import Node

import goalwire
from benchmarks.soak.report import Report
from benchmarks.soak.work import MORTAL, STEADY
from goalwire.errors import ShutDownError

TRIES = 100
"""How many commands of each kind are given after the end."""
PAUSE_S = 0.1
TIMEOUT_S = 2.0


class Orders:
    """The commands of one kind: numbers them, and counts what becomes of those after the end."""

    def __init__(self, kind: str, ok: Callable[[], bool], report: Report) -> None:
        self._kind = kind
        self._ok = ok
        self._report = report
        self._number = self._tried = self._refused = 0
        self.goes_on = True

    def next(self) -> int:
        """Return the next number; a negative one after the end."""
        self._number += 1
        if self._ok():
            return self._number
        self._tried += 1
        self.goes_on = self._tried < TRIES
        return -self._number

    def refused(self) -> None:
        """The library has refused a command: the context has ended."""
        self._refused += 1

    def tell(self) -> None:
        """Say how many were tried after the end, and how many at least went through."""
        self._report.say('stopped', self._kind, self._tried, max(0, self._tried - self._refused))

    def give(self, command: Callable[[int], object]) -> None:
        """Give one command after the other, whatever they raise, until enough were tried after the end."""
        while self.goes_on:
            number = self.next()
            try:
                command(number)
            except ShutDownError:
                self.refused()
            except Exception:
                self._ok()  # whatever it was: the next one
            if number > 0:
                time.sleep(PAUSE_S)
        self.tell()

    async def give_async(self, command: Callable[[int], Awaitable[object]]) -> None:
        """The same in a loop of asyncio."""
        while self.goes_on:
            number = self.next()
            try:
                await command(number)
            except ShutDownError:
                self.refused()
            except Exception:
                self._ok()
            await asyncio.sleep(PAUSE_S if number > 0 else 0)
        self.tell()


def in_rclpy(report: Report, context: Context) -> None:
    """Command all servers until `context` ends, and then a little longer."""
    node = Node('rclpy_commander', context=context)
    threads = [
        threading.Thread(target=Orders(kind, context.ok, report).give, args=(command,))
        for name in (*STEADY, *MORTAL)
        for kind, command in _rclpy_commands(node, name).items()
    ]
    report.say('ready')
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    node.destroy_node()


def _rclpy_commands(node: Node, name: str) -> dict[str, Callable[[int], object]]:
    publisher = node.create_publisher(Int64, f'{name}/move', 10)
    client = node.create_client(AddTwoInts, f'{name}/step')
    action = ActionClient(node, Fibonacci, f'{name}/walk')
    client.call_timeout = action.call_timeout = TIMEOUT_S
    return {
        'message': lambda number: publisher.publish(Int64(data=number)),
        'call': lambda number: client.call(AddTwoInts.Request(a=number)),
        'goal': lambda number: action.send_goal(Fibonacci.Goal(order=number)),
    }


async def in_asyncio(report: Report, context: Context) -> None:
    """The same in the asyncio API."""
    async with goalwire.Node('asyncio_commander', context=context) as node:
        commands = [_asyncio_commands(node, name) for name in (*STEADY, *MORTAL)]
        report.say('ready')  # from now on SIGTERM may come
        async with asyncio.TaskGroup() as group:
            for each in commands:
                for kind, command in each.items():
                    group.create_task(Orders(kind, context.ok, report).give_async(command))


def _asyncio_commands(node: goalwire.Node, name: str) -> dict[str, Callable[[int], Awaitable[object]]]:
    publisher = node.publisher(Int64, f'{name}/move')
    client = node.client(AddTwoInts, f'{name}/step', timeout=TIMEOUT_S)
    action = node.action(Fibonacci, f'{name}/walk', timeout=TIMEOUT_S)

    async def publish(number: int) -> None:
        publisher.publish(data=number)

    return {
        'message': publish,
        'call': lambda number: client.call(a=number),
        'goal': lambda number: action.call(order=number),
    }


def run(name: str, report: Report) -> None:
    """Run a commander as a program of its own, which SIGTERM ends."""
    rclpy.init(args=[])
    context = rclpy.get_default_context()
    if name.startswith('asyncio'):
        asyncio.run(in_asyncio(report, context))
    else:
        in_rclpy(report, context)
    rclpy.try_shutdown()


def run_here(name: str, report: Report, stop: threading.Event, seconds: float) -> None:
    """Run one in this process, and end its context after so long as a signal would, or when `stop` is set."""
    context = Context()
    context.init(args=[])

    def end() -> None:
        stop.wait(seconds)
        context.shutdown_signal.end('SIGTERM')

    ending = threading.Thread(target=end)
    ending.start()
    try:
        if name.startswith('asyncio'):
            asyncio.run(in_asyncio(report, context))
        else:
            in_rclpy(report, context)
    finally:
        ending.join()
        with suppress(RuntimeError):
            context.try_shutdown()
