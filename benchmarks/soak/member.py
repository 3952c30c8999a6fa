"""One member as a process: `python -m benchmarks.soak.member NAME INCARNATION`, until standard input ends.

`world` is all of them in one process, for a transport that is within one process; there nobody is killed,
but servers and clients leave their blocks in the middle of their work, and come back.
"""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from itertools import count
from random import Random
from typing import Any

from benchmarks.soak import asyncio_members, commanders
from benchmarks.soak.report import Report
from goalwire.logging import LoggingSeverity
from goalwire.logging.levels import set_logger_level

ASYNCIO: dict[str, Callable[[Report, asyncio.Event], Coroutine[Any, Any, None]]] = {
    'steady server': lambda report, stop: asyncio_members.serve('steady', report, stop),
    'left server': lambda report, stop: asyncio_members.serve('left', report, stop),
    'steady client': lambda report, stop: asyncio_members.call('steady', report, stop),
    'mortal client': lambda report, stop: asyncio_members.call('mortal', report, stop, workers=4),
}
RCLPY = ('right server', 'rclpy client')
SERVERS = ('steady server', 'left server', 'right server')
CLIENTS = ('steady client', 'mortal client', 'rclpy client')
KILLED = ('left server', 'right server', 'mortal client')
SURVIVORS = ('steady server', 'steady client', 'rclpy client')
COMMANDERS = ('asyncio commander', 'rclpy commander')
"""Ended by SIGTERM, and started again."""
WORLD = 'world'


def told_to_stop() -> threading.Event:
    """Return an event that is set when standard input ends."""
    stop = threading.Event()

    def read() -> None:
        sys.stdin.read()
        stop.set()

    threading.Thread(target=read, name='stdin', daemon=True).start()
    return stop


async def _as_event(stop: threading.Event) -> asyncio.Event:
    loop, event = asyncio.get_running_loop(), asyncio.Event()

    def wait() -> None:
        stop.wait()
        with suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(event.set)

    threading.Thread(target=wait, name='stop', daemon=True).start()
    return event


async def _run(name: str, report: Report, stop: threading.Event) -> None:
    await ASYNCIO[name](report, await _as_event(stop))


def _run_rclpy(name: str, report: Report, stop: threading.Event) -> None:
    from benchmarks.soak import rclpy_members

    if name in SERVERS:
        rclpy_members.serve(name.split(maxsplit=1)[0], report, stop)
    else:
        rclpy_members.call('rclpy', report, stop)


async def _world(kill_every: float, stop: threading.Event) -> None:
    """All members; the clients stop first."""
    incarnations = count(1)
    stopped, servers_stop = await _as_event(stop), asyncio.Event()
    async with asyncio.TaskGroup() as servers:
        servers.create_task(ASYNCIO['steady server'](Report(next(incarnations)), servers_stop))
        servers.create_task(_often('left server', kill_every, incarnations, servers_stop))
        rclpy_stop = threading.Event()
        servers.create_task(
            asyncio.to_thread(_run_rclpy, 'right server', Report(next(incarnations)), rclpy_stop)
        )
        async with asyncio.TaskGroup() as clients:
            clients.create_task(ASYNCIO['steady client'](Report(next(incarnations)), stopped))
            clients.create_task(_often('mortal client', kill_every, incarnations, stopped))
            clients.create_task(
                asyncio.to_thread(_run_rclpy, 'rclpy client', Report(next(incarnations)), stop)
            )
            for name in COMMANDERS:
                clients.create_task(asyncio.to_thread(_command, name, kill_every, incarnations, stop))
        servers_stop.set()
        rclpy_stop.set()


def _command(name: str, every: float, incarnations: count[int], stop: threading.Event) -> None:
    """Run a commander again and again; each time its context ends under it."""
    random = Random()
    while not stop.is_set():
        report = Report(next(incarnations))
        commanders.run_here(name, report, stop, random.uniform(0.5, 1.5) * every)
        report.say('terminated')


async def _often(name: str, every: float, incarnations: count[int], stop: asyncio.Event) -> None:
    """Run a member again and again; most of its lives are cut short."""
    random, stopping = Random(), asyncio.ensure_future(stop.wait())
    while not stop.is_set():
        report = Report(next(incarnations))
        life = asyncio.ensure_future(ASYNCIO[name](report, stop))
        await asyncio.wait(
            [life, stopping], timeout=random.uniform(0.5, 1.5) * every, return_when='FIRST_COMPLETED'
        )
        if not stop.is_set():
            life.cancel()
            report.say('left')
        with suppress(asyncio.CancelledError):
            await life
    stopping.cancel()


def main() -> None:
    """Run one member, or the world."""
    name, number = sys.argv[1:]
    stop = told_to_stop()
    set_logger_level('', LoggingSeverity.FATAL)  # failures are counted by those who meet them
    if name == WORLD:
        asyncio.run(_world(float(number), stop))
    elif name in COMMANDERS:
        commanders.run(name, Report(int(number)))
    elif name in RCLPY:
        _run_rclpy(name, Report(int(number)), stop)
    else:
        asyncio.run(_run(name, Report(int(number)), stop))


if __name__ == '__main__':
    main()
