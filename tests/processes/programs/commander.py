"""Commands a robot (commanded.py) as fast as it can. Arguments: front, kind of command, how stubborn.

'stubborn' catches whatever a command raises and goes on; it says in the end which of the commands that began
after the end of the context went through. 'plain' catches nothing.
"""

import asyncio
import sys
from collections.abc import Callable

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.msg import Int64
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.signals import install_signal_handlers

import goalwire

TRIES = 200
"""How many commands a stubborn program tries after the end."""

front, kind, stubborn = sys.argv[1], sys.argv[2], sys.argv[3] == 'stubborn'


class Attempts:
    """Numbers commands, negative ones after the end of the context, and counts what becomes of those."""

    def __init__(self, ok: Callable[[], bool]) -> None:
        self._ok = ok
        self._number = 0
        self._is_late = False
        self.tried = 0
        self.through = 0
        self.raised: set[str] = set()

    def next(self) -> int:
        self._is_late = not self._ok()
        self.tried += self._is_late
        self._number += 1
        return -self._number if self._is_late else self._number

    def ended(self, error: Exception | None) -> None:
        if error is not None:
            self.raised.add(type(error).__name__)
        elif self._is_late:
            self.through += 1

    def tell(self) -> None:
        print(f'{self.through} of {self.tried} late commands went through; {sorted(self.raised)}')


def in_rclpy() -> None:
    rclpy.init()
    node = Node('commander')
    attempts = Attempts(rclpy.ok)
    command = command_of(node)
    while attempts.tried < TRIES:
        number = attempts.next()
        try:
            command(number)
        except Exception as error:
            if not stubborn:
                raise
            attempts.ended(error)
        else:
            attempts.ended(None)
    attempts.tell()


def command_of(node: Node) -> Callable[[int], object]:
    if kind == 'publish':
        publisher = node.create_publisher(Int64, 'move', 10)
        return lambda number: publisher.publish(Int64(data=number))
    if kind == 'call':
        client = node.create_client(AddTwoInts, 'step')
        client.wait_for_service()
        return lambda number: client.call(AddTwoInts.Request(a=number))
    action = ActionClient(node, Fibonacci, 'walk')
    action.wait_for_server()
    return lambda number: action.send_goal(Fibonacci.Goal(order=number))


async def in_asyncio() -> None:
    install_signal_handlers()  # goalwire.Node leaves signals alone
    async with goalwire.Node('commander') as node:
        attempts = Attempts(node.context.ok)
        publisher = node.publisher(Int64, 'move')
        client = node.client(AddTwoInts, 'step')
        action = node.action(Fibonacci, 'walk')
        while attempts.tried < TRIES:
            number = attempts.next()
            try:
                if kind == 'publish':
                    publisher.publish(data=number)
                    await asyncio.sleep(0)
                elif kind == 'call':
                    await client.call(a=number)
                else:
                    await action.call(order=number)
            except Exception as error:
                if not stubborn:
                    raise
                attempts.ended(error)
            else:
                attempts.ended(None)
        attempts.tell()


if front == 'asyncio':
    asyncio.run(in_asyncio())
else:
    in_rclpy()
