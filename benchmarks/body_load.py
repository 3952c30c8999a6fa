"""The humanoid in physics with everything running: benchmarks/body_load.py [--seconds N] [--name NAME].

Brings robots up with physics, lets each carry out missions one after the other, and prints what
`real_time_factor` was meanwhile, and each program's share of a processor. With --view the console serves
its page as well. Needs MuJoCo.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import AsyncExitStack, suppress
from pathlib import Path

from std_msgs.msg import Float64

import goalwire

ROOT = Path(__file__).resolve().parents[1]
DOMAIN = '97'
READY = 'Server ready'  # of arms and base: two of a robot
STARTED = re.compile(r'started (\S+) \(pid (\d+)\)|\[(view)\] pid (\d+)')


def used(pid: int) -> float:
    """Processor seconds of a process."""
    fields = Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


async def started(ends: AsyncExitStack, *arguments: str) -> asyncio.subprocess.Process:
    """`humanoid ARGUMENTS`, told to stop at the end."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        '-m',
        'humanoid',
        *arguments,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )

    async def stop() -> None:
        with suppress(ProcessLookupError):
            process.send_signal(signal.SIGINT)
        await process.communicate()

    ends.push_async_callback(stop)
    return process


async def brought_up(ends: AsyncExitStack, arguments: list[str], robots: int) -> Mapping[str, int]:
    """The pids of the robots' programs by name, once all of them are ready."""
    up = await started(ends, 'up', '--physics', *arguments)
    assert up.stdout is not None
    pids, ready = {}, 0
    while ready < 2 * robots:
        line = (await up.stdout.readline()).decode()
        if not line:
            raise SystemExit('humanoid up has ended')
        if found := STARTED.search(line):
            pids[found[1] or found[3]] = int(found[2] or found[4])
        ready += READY in line
    ends.callback(asyncio.create_task(drained(up.stdout)).cancel)
    return pids


async def drained(stream: asyncio.StreamReader) -> None:
    """Nothing that the programs print may hold them up."""
    while await stream.read(65536):
        pass


async def missions(name: str, tally: list[bool]) -> None:
    """One after the other; whether each ended well."""
    while True:
        async with AsyncExitStack() as ends:
            mission = await started(
                ends, 'mission', *(['--ros-args', '-r', f'__ns:=/{name}'] if name else [])
            )
            output, _ = await mission.communicate()
            tally.append(mission.returncode == 0 and b'10 of 10' in output)


async def listen(node: goalwire.Node, name: str, factors: list[float]) -> None:
    async for factor in node.subscription(
        Float64, f'{name}/real_time_factor' if name else 'real_time_factor'
    ):
        factors.append(factor.data)  # noqa: PERF401 - it is looked at while they come


async def measure(seconds: float, names: list[str], *, view: bool) -> None:
    """Print the figures."""
    async with AsyncExitStack() as ends, goalwire.Node('load') as node:
        arguments = [part for name in names for part in ('--name', name)]
        pids = await brought_up(ends, [*arguments, *(['--view'] if view else [])], max(len(names), 1))
        factors: list[float] = []
        tally: list[bool] = []
        tasks = []
        for name in names or ['']:
            tasks += [
                asyncio.create_task(listen(node, name, factors)),
                asyncio.create_task(missions(name, tally)),
            ]
        began, before = time.monotonic(), {name: used(pid) for name, pid in pids.items()}
        await asyncio.sleep(seconds)
        took = time.monotonic() - began
        shares = {name: (used(pid) - before[name]) / took for name, pid in pids.items()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    told = sorted(factors)
    print(f'real_time_factor of {len(told)} s: least {told[0]:.3f}, mean {sum(told) / len(told):.3f}')
    print(f'missions that ended with ten of ten: {sum(tally)} of {len(tally)}')
    for name, share in shares.items():
        print(f'{name}: {share * 100:.1f} % of a processor')
    print(f'all: {sum(shares.values()) * 100:.1f} %, of {len(os.sched_getaffinity(0))} processors')


def main() -> int:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=60.0)
    parser.add_argument('--name', action='append', default=[], help='a robot of that name, as in humanoid up')
    parser.add_argument('--view', action='store_true')
    options = parser.parse_args()
    os.environ.setdefault('ROS_DOMAIN_ID', DOMAIN)
    os.environ['PYTHONPATH'] = str(ROOT / 'robot' / 'humanoid')
    os.environ['GOALWIRE_INTERFACE_PATH'] = str(ROOT / 'robot')
    os.environ['BROWSER'] = 'true'  # nobody looks
    asyncio.run(measure(options.seconds, options.name, view=options.view))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
