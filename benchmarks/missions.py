"""The cost of the journal of missions: python -m benchmarks.missions [FOLDER].

`FOLDER` is on the disk to measure, by default the folder for temporary files. The action server and the
runner are in one process, on the transport `memory`, so that little besides the journal is measured.
"""

from __future__ import annotations

import asyncio
import os
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from statistics import median, quantiles
from typing import Any

from example_interfaces.action import Fibonacci

import goalwire
from goalwire.missions import MissionState, Runner, Steps, mission

STEPS = 1000
REST_S = 5.0


class Times:
    """The times of many like things: how long each took, and the processor's time for all of them."""

    def __init__(self) -> None:
        self._took: list[float] = []
        self._cpu = 0.0

    async def measure(self, do: Callable[[int], Awaitable[object]], number: int) -> None:
        """Do it so often, and take the times."""
        cpu = time.process_time()
        for each in range(number):
            begun = time.perf_counter()
            await do(each)
            self._took.append(time.perf_counter() - begun)
        self._cpu += time.process_time() - cpu

    def __str__(self) -> str:
        p99 = quantiles(self._took, n=100)[-1]
        cpu = self._cpu / len(self._took)
        return f'{median(self._took) * 1e6:6.0f} | {p99 * 1e6:7.0f} | {cpu * 1e6:6.0f}'


HAS_DRIVEN = asyncio.Event()
"""Set when the mission `rest` has come behind its goals."""
TIMES: dict[str, Times] = {}


def take(name: str) -> Times:
    """Return the times of a row of the table."""
    return TIMES.setdefault(name, Times())


async def do_nothing() -> None:
    """Stand for a mission's own code."""


@mission(resume='auto')
async def own_code(m: Steps) -> None:
    await take('own code, a step').measure(lambda _: m.run(do_nothing), STEPS)


@mission(resume='auto')
async def goals(m: Steps) -> None:
    drive = m.action(Fibonacci, 'drive')
    await take('a goal, a step').measure(lambda each: drive.call(order=each), STEPS)


@mission(resume='auto')
async def rest(m: Steps) -> None:
    drive = m.action(Fibonacci, 'drive')
    for each in range(STEPS):
        await drive.call(order=each)
    HAS_DRIVEN.set()
    await m.approve('go on?')


async def answer(goal: goalwire.Goal[Any, Any]) -> Fibonacci.Result:
    return Fibonacci.Result(sequence=[goal.request.order])


async def work(path: Path) -> float:
    """Do steps with a journal and without one; return the bytes that a goal takes in the journal."""
    async with goalwire.Node('base') as base, goalwire.Node('runner') as node:
        base.action_server(Fibonacci, 'drive', answer)
        client = node.action(Fibonacci, 'drive')
        await take('own code, without a journal').measure(lambda _: do_nothing(), STEPS)
        await take('a goal, without a journal').measure(lambda each: client.call(order=each), STEPS)
        async with Runner(node, path) as runner:
            for each in (own_code, goals):
                run = await runner.start(each, id=each.name)
                await run.wait()
        before = path.stat().st_size  # noqa: ASYNC240 - it is short
        async with Runner(node, path) as runner:
            run = await runner.start(rest, id='rest')
            await run.until(MissionState.APPROVAL)
        return (path.stat().st_size - before) / STEPS  # noqa: ASYNC240


async def go_on(path: Path) -> tuple[float, float, float]:
    """Go on with a mission that has done many goals and waits for a person.

    Returns how many s that takes, how many s of a core, and how much of a core the waiting takes.
    """
    HAS_DRIVEN.clear()
    async with goalwire.Node('runner') as node:
        begun, cpu = time.perf_counter(), time.process_time()
        async with Runner(node, path, missions=[rest]):
            await HAS_DRIVEN.wait()
            took, busy = time.perf_counter() - begun, time.process_time() - cpu
            cpu = time.process_time()
            await asyncio.sleep(REST_S)
            return took, busy, (time.process_time() - cpu) / REST_S


async def main(folder: Path) -> None:
    """Measure, and print the figures."""
    path = folder / 'missions.db'
    a_goal = await work(path)
    took, busy, at_rest = await go_on(path)
    print(f'{STEPS} each, on {folder}\n')
    print('| | µs, median | µs, 99 % | µs of a core |\n|---|---|---|---|')
    for name, times in TIMES.items():
        print(f'| {name} | {times} |')
    print(f'\na goal takes {a_goal:.0f} bytes of the journal')
    print(f'a mission with {STEPS} goals goes on after {took * 1e3:.0f} ms, {busy * 1e3:.0f} ms of a core')
    print(f'a mission that waits takes {at_rest:.3%} of a core')


if __name__ == '__main__':
    os.environ['RMW_IMPLEMENTATION'] = 'goalwire_memory'
    if len(sys.argv) > 1:
        asyncio.run(main(Path(sys.argv[1])))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            asyncio.run(main(Path(temporary)))
