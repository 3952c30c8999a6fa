"""`ros2 bag record` under load, beside a peer that reads nothing: python -m benchmarks.recording.

One program publishes pictures of 1 MB and small messages on 20 topics, another subscribes to the pictures and
is stopped. The recorder writes files of 1 GB and keeps the latest four. It prints what the disk can do, what
the recorder takes, and at the end how many messages were published, recorded and lost. It needs a
machine with nothing else to do, Linux, and 6 GB in --folder.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import signal
import sys
import tempfile
import time
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from typing import NamedTuple

import goalwire

PICTURE_BYTES = 1_000_000
SMALL_TOPICS = 20
TICK_S = 0.005
LOOK_S = 10.0
_FILE_BYTES, _FILES = 1_000_000_000, 4
_PROBE_BYTES = 2_000_000_000
_DOMAIN = '98'
_END = re.compile(r"' has [\d,]+ messages|messages were (dropped, |lost on)")


# -- the programs beside the recorder ------------------------------------------------------------------------


async def publish(seconds: float, megabytes: float, messages: float) -> None:
    """Publish so much each second; print how many messages that were in all."""
    from std_msgs.msg import String
    from std_msgs.msg import UInt8MultiArray as Picture

    pictures_a_tick = megabytes * 1e6 / PICTURE_BYTES * TICK_S
    small_a_tick = max(0.0, messages * TICK_S - pictures_a_tick)
    async with goalwire.Node('load') as node:
        pictures = node.publisher(Picture, 'pictures', qos=10)
        small = [node.publisher(String, f'small_{at}', qos=100) for at in range(SMALL_TOPICS)]
        picture, word = Picture(data=bytes(PICTURE_BYTES)), String(data='x' * 100)
        await asyncio.sleep(3.0)  # the recorder finds the topics
        began, tick = time.monotonic(), 0
        sent_pictures = sent_small = 0
        while time.monotonic() < began + seconds:
            tick += 1
            while sent_pictures < tick * pictures_a_tick:
                pictures.publish(picture)
                sent_pictures += 1
            while sent_small < tick * small_a_tick:
                small[sent_small % SMALL_TOPICS].publish(word)
                sent_small += 1
            await asyncio.sleep(max(0.0, began + tick * TICK_S - time.monotonic()))
        count = sent_pictures + sent_small
        took = time.monotonic() - began
        print(f'published {count} in {took:.1f} s', flush=True)
        await asyncio.sleep(3.0)  # what waits goes out


async def read_nothing() -> None:
    """Subscribe to the pictures, and stop."""
    from std_msgs.msg import UInt8MultiArray as Picture

    async with goalwire.Node('slow') as node:
        node.subscription(Picture, 'pictures', qos=10)
        await asyncio.sleep(2.0)
        os.kill(os.getpid(), signal.SIGSTOP)


# -- measuring -----------------------------------------------------------------------------------------------


class Use(NamedTuple):
    """The resources that a process has used."""

    seconds: float
    """The processor time in s."""
    megabytes: float
    """The peak of its memory in MB."""


def use_of(pid: int) -> Use:
    """Look at a process; its children do not count."""
    fields = Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    status = Path(f'/proc/{pid}/status').read_text(encoding='utf-8')
    most = re.search(r'VmHWM:\s+(\d+) kB', status)
    seconds = (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
    return Use(seconds, int(most[1]) / 1000 if most else 0.0)


def disk_rate(folder: Path) -> float:
    """Return how many MB a second a plain program writes there, with the disk having them."""
    path, block = folder / 'probe', bytes(10_000_000)
    began = time.monotonic()
    with path.open('wb') as file:
        for _ in range(_PROBE_BYTES // len(block)):
            file.write(block)
        file.flush()
        os.fsync(file.fileno())
    took = time.monotonic() - began
    path.unlink()
    return _PROBE_BYTES / 1e6 / took


async def measure(arguments: argparse.Namespace, folder: Path) -> None:
    """Run everything, and print what it was like."""
    os.environ['ROS_DOMAIN_ID'] = _DOMAIN
    print(f'disk: {disk_rate(folder):.0f} MB/s; load of the machine: {os.getloadavg()[0]:.1f}', flush=True)
    own = [sys.executable, '-m', 'benchmarks.recording']
    load = [f'{value}' for value in (arguments.seconds, arguments.megabytes, arguments.messages)]
    bag = ['-o', str(folder / 'bag'), '-b', str(_FILE_BYTES), '--max-bag-files', str(_FILES)]
    async with AsyncExitStack() as ends:
        recorder = await _start(ends, sys.executable, '-m', 'goalwire', 'bag', 'record', '--all-topics', *bag)
        publisher = await _start(ends, *own, '--publish', *load)
        if not arguments.without_peer:
            await _start(ends, *own, '--read-nothing')
        publishing = asyncio.create_task(_lines(publisher))
        before, began = use_of(recorder.pid), time.monotonic()
        while not publishing.done():
            await asyncio.wait({publishing}, timeout=LOOK_S)
            use, took = use_of(recorder.pid), time.monotonic() - began
            share = (use.seconds - before.seconds) / took
            print(f'{took:5.0f} s: {share:.2f} of a core, {use.megabytes:.0f} MB at most', flush=True)
        print(''.join(publishing.result()).strip())
        recorder.send_signal(signal.SIGINT)
        for line in await _lines(recorder):
            if _END.search(line):
                print(line.strip())


async def _start(ends: AsyncExitStack, *command: str) -> asyncio.subprocess.Process:
    """Start a program, which ends with the stack."""
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT
    )

    async def end() -> None:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()

    ends.push_async_callback(end)
    return process


async def _lines(process: asyncio.subprocess.Process) -> list[str]:
    assert process.stdout is not None
    return [line.decode() async for line in process.stdout]


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument('--seconds', type=float, default=600.0)
    parser.add_argument('--megabytes', type=float, default=200.0, help='a second')
    parser.add_argument('--messages', type=float, default=5000.0, help='a second')
    parser.add_argument(
        '--folder', type=Path, default=None, help='on the disk that is tried (a temporary one)'
    )
    parser.add_argument('--without-peer', action='store_true', help='start no peer that reads nothing')
    parser.add_argument('--publish', nargs=3, type=float, help=argparse.SUPPRESS)
    parser.add_argument('--read-nothing', action='store_true', help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.publish:
        asyncio.run(publish(*arguments.publish))
    elif arguments.read_nothing:
        asyncio.run(read_nothing())
    else:
        if arguments.folder:
            arguments.folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=arguments.folder, prefix='recording-') as folder:
            asyncio.run(measure(arguments, Path(folder)))


if __name__ == '__main__':
    main()
