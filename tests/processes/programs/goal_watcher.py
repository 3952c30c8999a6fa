"""Serves goals that never end by themselves, and says when each begins and ends.

Its argument says what it does when clients go. A goal of order 1 is accepted when a line comes from stdin.
"""

import asyncio
import sys
import time
from typing import Any

from example_interfaces.action import Fibonacci

import goalwire


async def accept(goal: Fibonacci.Goal) -> bool:
    if goal.order == 1:
        print('deciding', flush=True)
        await asyncio.to_thread(sys.stdin.readline)
        print('decided', flush=True)
    return True


async def execute(goal: 'goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]') -> Fibonacci.Result:
    print(f'began {goal.request.order} ', flush=True)
    try:
        await asyncio.Event().wait()
    finally:
        print(f'ended {goal.request.order} at {time.monotonic()}', flush=True)
    return Fibonacci.Result()


async def main() -> None:
    async with goalwire.Node('watcher') as node:
        choice: Any = sys.argv[1]
        node.action_server(Fibonacci, 'watched', execute, accept=accept, on_client_lost=choice)
        print('ready', flush=True)
        await asyncio.Event().wait()


asyncio.run(main())
