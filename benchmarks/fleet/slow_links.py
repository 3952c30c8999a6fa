"""A relay for the links of a fleet: late, narrow, and now and then stalled or broken.

python -m benchmarks.fleet.slow_links PORT SERVER_PORT [--delay-ms 100] [--mbit 10] [--stall-every 60]
[--break-every 0]. Each connection is one link. It prints `ready`, and at SIGINT how many stalls and breaks
there were.
"""

from __future__ import annotations

import argparse
import asyncio
import random
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


class Relay:
    """Passes connections on to the server's port."""

    def __init__(self, server_port: int, faults: Faults) -> None:
        self.seen: Counter[str] = Counter()
        self._server_port = server_port
        self._faults = faults

    async def connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry one connection until either side ends it, or it breaks."""
        writers = [writer]
        try:
            away, back = await asyncio.open_connection('127.0.0.1', self._server_port)
            writers.append(back)
            ways = [
                asyncio.ensure_future(self._carry(reader, back)),
                asyncio.ensure_future(self._carry(away, writer)),
                asyncio.ensure_future(self._wait_for_break()),
            ]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
        except OSError:
            pass  # the server is away: so is the link
        finally:
            for each in writers:
                each.transport.abort()

    async def _carry(self, source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
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
                    return
                if loop.time() > stall:
                    self.seen['stalls'] += 1
                    due = max(due, loop.time() + random.uniform(0.5, _LONGEST_STALL_S))
                    stall = due + self._next(self._faults.stall_every_s) - loop.time()
                due = max(due, loop.time() + len(chunk) / self._faults.bytes_a_second)
                await asyncio.sleep(due - loop.time())
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


async def serve(port: int, relay: Relay) -> None:
    """Serve until the task is cancelled."""
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
    chosen = parser.parse_args()
    faults = Faults(chosen.delay_ms / 1e3, chosen.mbit * 125e3, chosen.stall_every, chosen.break_every)
    relay = Relay(chosen.server_port, faults)
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(chosen.port, relay))
    print(dict(relay.seen), flush=True)


if __name__ == '__main__':
    main()
