"""Runs the humanoid's thirteen steps: `thirteen_runner.py FOLDER JOURNAL BOUNDARY`.

`FOLDER` has the example. The program stands still at the boundary with this number: it prints its name, and
reads a line before it goes on. A number below 0 is never reached. At the end it prints how many boundaries it
has passed, the mission's steps and state, and why.
"""

from __future__ import annotations

import asyncio
import itertools
import sys
from typing import Any

import goalwire
from goalwire.missions import MissionState, Runner


async def main(folder: str, journal: str, chosen: int) -> None:
    sys.path.insert(0, folder)
    thirteen: Any = __import__('thirteen').thirteen
    numbers = itertools.count()

    def stand_still(name: str, step: str) -> None:
        if next(numbers) == chosen:
            print(f'boundary: {name}, {step}', flush=True)
            sys.stdin.readline()

    async with (
        goalwire.Node('runner') as node,
        Runner(node, journal, missions=[thirteen], boundary=stand_still) as runner,
    ):
        run = await runner.start(thirteen, id='demo')
        await run.until(*(each for each in MissionState if each.waits_for_somebody))
        steps = len(run.result) if isinstance(run.result, dict) else 0
        print(f'end: {next(numbers)} {steps} {run.state}: {run.why}', flush=True)


asyncio.run(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
