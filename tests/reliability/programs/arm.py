"""A server: `ask` answers, `hang` never does, `count` counts a step every 20 ms."""

from __future__ import annotations

import asyncio

from example_interfaces.action import Fibonacci
from std_srvs.srv import Trigger

import goalwire


async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
    print('goal begun')
    how = 'left'
    try:
        for number in range(goal.request.order):
            goal.feedback(sequence=[number])
            await asyncio.sleep(0.02)
        how = 'reached'
    finally:
        print('goal', how)
    return Fibonacci.Result(sequence=[goal.request.order])


async def hang(_: Trigger.Request) -> Trigger.Response:
    print('hangs')
    await asyncio.Event().wait()
    raise AssertionError


async def main() -> None:
    async with goalwire.Node('arm') as node:
        node.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
        node.service(Trigger, 'hang', hang)
        node.action_server(Fibonacci, 'count', count, on_client_lost='cancel')
        print('ready')
        await asyncio.Event().wait()


if __name__ == '__main__':
    try:
        asyncio.run(main())
    except KeyboardInterrupt:
        print('stopped')
