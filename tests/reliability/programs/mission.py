"""A client that does what its standard input says, and tells how each thing ended.

`call NAME SECONDS [NUMBER]`, `goal ORDER SECONDS`: each end is a line `ended KIND TIME SECONDS`: when, in ns
of steady time, which compares with other processes' times, and after how long. `leave` ends it.
"""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Awaitable

from example_interfaces.action import Fibonacci
from std_srvs.srv import Trigger

import goalwire
from goalwire.aio.services import Client
from goalwire.errors import GoalwireError


class Mission:
    """The node's clients, made when they are first needed, and what can be asked for."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self._clients: dict[str, Client[Trigger.Request, Trigger.Response]] = {}

    async def do(self, command: str, *arguments: str) -> None:
        """Carry one line out."""
        await (self.call if command == 'call' else self.goal)(*arguments)

    async def call(self, name: str, seconds: str, number: str = '1') -> None:
        """Call a service, or so many times, one after the other."""
        client = self._clients.get(name) or self._node.client(Trigger, name)
        self._clients[name] = client
        for _ in range(int(number)):
            await told(client.call(timeout=float(seconds)))

    async def goal(self, order: str, seconds: str) -> None:
        """Have the server count."""
        await told(self._node.action(Fibonacci, 'count').call(order=int(order), timeout=float(seconds)))


async def told(work: Awaitable[object]) -> None:
    kind, began = 'done', time.monotonic_ns()
    try:
        await work
    except GoalwireError as error:
        kind = type(error).__name__
    now = time.monotonic_ns()
    print('ended', kind, now, (now - began) / 1e9)


async def main() -> None:
    async with goalwire.Node('mission') as node:
        mission = Mission(node)
        print('ready')
        while line := await asyncio.to_thread(sys.stdin.readline):
            command, *arguments = line.split()
            if command == 'leave':
                break
            await mission.do(command, *arguments)
    print('left')


if __name__ == '__main__':
    asyncio.run(main())
