"""Serves the action `drive`, and writes each execution into the file that it is given.

`base.py EXECUTIONS SHORT LONG [JOURNAL]`

A goal takes SHORT s; every eighth takes LONG s, so that a runner that was killed and started again finds it
running.
"""

from __future__ import annotations

import asyncio
import sys
import time
from pathlib import Path

from example_interfaces.action import Fibonacci

import goalwire


async def main(path: str, short: str, long: str, journal: str | None = None) -> None:
    with Path(path).open('a', encoding='utf-8') as executions:  # noqa: ASYNC230 - it is short
        async with goalwire.Node('base') as node:

            def note(goal_id: bytes, what: str) -> None:
                refused = server.statistics().goals.refused
                print(goal_id.hex(), what, refused, time.monotonic(), file=executions, flush=True)

            async def drive(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
                note(goal.goal_id, 'begun')
                await asyncio.sleep(float(long if goal.request.order % 8 == 3 else short))
                note(goal.goal_id, 'ended')
                return Fibonacci.Result(sequence=[goal.request.order])

            server = node.action_server(Fibonacci, 'drive', drive, journal=journal)
            print('ready', flush=True)
            await asyncio.Event().wait()


asyncio.run(main(*sys.argv[1:]))
