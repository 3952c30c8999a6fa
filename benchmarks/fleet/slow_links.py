"""A relay for the links of a fleet: late, narrow, and now and then stalled or broken.

python -m benchmarks.fleet.slow_links PORT SERVER_PORT [--delay-ms 100] [--mbit 10] [--stall-every 60]
[--break-every 0] [--control]. Each connection is one link. It prints `ready`, and at SIGINT how many stalls,
breaks and partitions there were. With --control it reads its input: a line `partition SECONDS all` stops all
links for so long, also new ones, and `partition SECONDS one` stops one link; at a line `count` it prints the
stalls, breaks and partitions by now, as JSON.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import random
import sys
from collections import Counter
from contextlib import suppress
from typing import NamedTuple

_CHUNK = 16_384
_WAITING = 64
"""Chunks on their way in one direction; then the sender has to wait, as a full radio lets it."""
_LONGEST_STALL_S = 5.0
"""Shorter than a lease of a fleet's routers: the link stalls, but is not lost."""


class Faults(NamedTuple):
    """How bad the links are. A time of 0 between two faults means never."""

    delay_s: float
    bytes_a_second: float
    stall_every_s: float
    break_every_s: float


class _Link:
    """One connection that is relayed."""

    partitioned_until = 0.0


class Relay:
    """Passes connections on to the server's port."""

    def __init__(self, server_port: int, faults: Faults) -> None:
        self.seen: Counter[str] = Counter()
        self._server_port = server_port
        self._faults = faults
        self._links: set[_Link] = set()
        self._partitioned_until = 0.0

    def partition(self, seconds: float, *, everything: bool) -> None:
        """Stop one link, or all links and those that are made in the meantime. Nothing ends: it is silent."""
        until = asyncio.get_running_loop().time() + seconds
        self.seen['partitions'] += 1
        if everything:
            self._partitioned_until = until
        elif self._links:
            random.choice(list(self._links)).partitioned_until = until

    async def _wait_for(self, link: _Link, due: float = 0.0) -> None:
        """Wait until `due`, and until no partition stops the link."""
        while (rest := self._silence(link, due)) > 0:  # noqa: ASYNC110 - a partition may begin meanwhile
            await asyncio.sleep(rest)

    def _silence(self, link: _Link, due: float) -> float:
        """Return for how many more seconds nothing passes."""
        until = max(due, link.partitioned_until, self._partitioned_until)
        return until - asyncio.get_running_loop().time()

    async def connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry one connection until either side ends it, or it breaks."""
        writers = [writer]
        link = _Link()
        self._links.add(link)
        try:
            await self._wait_for(link)
            away, back = await asyncio.open_connection('127.0.0.1', self._server_port)
            writers.append(back)
            ways = [
                asyncio.ensure_future(self._carry(link, reader, back)),
                asyncio.ensure_future(self._carry(link, away, writer)),
                asyncio.ensure_future(self._wait_for_break()),
            ]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
        except (OSError, asyncio.CancelledError):
            pass  # the server is away; or the relay ends, and asyncio would print a traceback for each link
        finally:
            self._links.remove(link)
            for each in writers:
                each.transport.abort()

    async def _carry(self, link: _Link, source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
        """Carry one direction: a chunk arrives when its delay is over and all before it have arrived."""
        loop = asyncio.get_running_loop()
        on_the_way: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(_WAITING)

        async def receive() -> None:
            while chunk := await source.read(_CHUNK):
                await on_the_way.put((loop.time() + self._faults.delay_s, chunk))
            await on_the_way.put((loop.time() + self._faults.delay_s, b''))

        receiving = asyncio.ensure_future(receive())
        stall = self._next(self._faults.stall_every_s)
        try:
            while True:
                due, chunk = await on_the_way.get()
                if not chunk:
                    await self._wait_for(link, due)
                    return
                if loop.time() > stall:
                    self.seen['stalls'] += 1
                    due = max(due, loop.time() + random.uniform(0.5, _LONGEST_STALL_S))
                    stall = due + self._next(self._faults.stall_every_s) - loop.time()
                due = max(due, loop.time() + len(chunk) / self._faults.bytes_a_second)
                await self._wait_for(link, due)
                target.write(chunk)
                await target.drain()
        except OSError:
            return
        finally:
            receiving.cancel()
            with suppress(asyncio.CancelledError, OSError):
                await receiving

    def _next(self, mean_s: float) -> float:
        now = asyncio.get_running_loop().time()
        return now + (random.expovariate(1 / mean_s) if mean_s else float('inf'))

    async def _wait_for_break(self) -> None:
        if not self._faults.break_every_s:
            await asyncio.Event().wait()
        await asyncio.sleep(random.expovariate(1 / self._faults.break_every_s))
        self.seen['breaks'] += 1


async def _obey(relay: Relay) -> None:
    """Read orders from the standard input."""
    lines = asyncio.StreamReader()
    protocol = asyncio.StreamReaderProtocol(lines)
    await asyncio.get_running_loop().connect_read_pipe(lambda: protocol, sys.stdin)
    while line := await lines.readline():
        match line.decode().split():
            case 'partition', seconds, which:
                relay.partition(float(seconds), everything=which == 'all')
            case _:
                print(json.dumps(relay.seen), flush=True)


async def serve(port: int, relay: Relay, *, is_controlled: bool = False) -> None:
    """Serve until the task is cancelled."""
    async with asyncio.TaskGroup() as group:
        if is_controlled:
            group.create_task(_obey(relay))
        async with await asyncio.start_server(relay.connect, '127.0.0.1', port, backlog=1000) as server:
            print('ready', flush=True)
            await server.serve_forever()


def main() -> None:
    """Relay until Ctrl-C."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('port', type=int)
    parser.add_argument('server_port', type=int)
    parser.add_argument('--delay-ms', type=float, default=100.0)
    parser.add_argument('--mbit', type=float, default=10.0)
    parser.add_argument('--stall-every', type=float, default=60.0, help='mean seconds; 0: never')
    parser.add_argument('--break-every', type=float, default=0.0, help='mean seconds; 0: never')
    parser.add_argument('--control', action='store_true', help='take orders from the standard input')
    chosen = parser.parse_args()
    faults = Faults(chosen.delay_ms / 1e3, chosen.mbit * 125e3, chosen.stall_every, chosen.break_every)
    relay = Relay(chosen.server_port, faults)
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(chosen.port, relay, is_controlled=chosen.control))
    print(dict(relay.seen), flush=True)


if __name__ == '__main__':
    main()
