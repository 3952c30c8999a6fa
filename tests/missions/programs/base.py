"""Serves the action `drive`, and writes each execution into the file that it is given."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

from example_interfaces.action import Fibonacci

import goalwire


async def main(path: str) -> None:
    with Path(path).open('a', encoding='utf-8') as executions:  # noqa: ASYNC230 - it is short
        async with goalwire.Node('base') as node:

            async def drive(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
                refused = server.statistics().goals.refused
                print(goal.goal_id.hex(), 'begun', refused, file=executions, flush=True)
                await asyncio.sleep(0.5)
                print(goal.goal_id.hex(), 'ended', refused, file=executions, flush=True)
                return Fibonacci.Result(sequence=[goal.request.order])

            server = node.action_server(Fibonacci, 'drive', drive)
            print('ready', flush=True)
            await asyncio.Event().wait()


asyncio.run(main(sys.argv[1]))
