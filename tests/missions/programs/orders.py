"""Carries out goals of the action `fetch` as missions, which drive the base: `orders.py JOURNAL`."""

from __future__ import annotations

import asyncio
import sys

from example_interfaces.action import Fibonacci

import goalwire
from goalwire.missions import Runner, Steps, mission, offer


@mission(resume='auto')
async def fetch(m: Steps, place: int) -> int:
    await m.action(Fibonacci, 'drive').call(order=place)
    await m.sleep(3.0)
    return place


async def main(path: str) -> None:
    async with goalwire.Node('orders') as node, Runner(node, path, missions=[fetch]) as runner:
        offer(
            node,
            runner,
            fetch,
            Fibonacci,
            'fetch',
            arguments=lambda goal: [goal.order],
            result=lambda place: Fibonacci.Result(sequence=[place]),
        )
        print('ready', flush=True)
        await runner.serve()


asyncio.run(main(sys.argv[1]))
