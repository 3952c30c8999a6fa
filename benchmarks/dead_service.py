"""100,000 calls that nobody answers, 1000 in flight, 50 ms each: what is left of them in both fronts.

    python -m benchmarks.dead_service [--calls N] [--wire RMW_IMPLEMENTATION ...]

For each wire and front: without a server (they wait for one) and with one that takes requests and never
answers (a process of its own but for the memory transport). Printed are the errors by type, calls per second,
and what has grown from one half of the calls to the end: resident memory, threads, open files, and what the
tables hold.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import os
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from std_srvs.srv import Trigger

from goalwire.entities.client import ClientCore
from goalwire.entities.context import Context
from goalwire.entities.node import NodeCore
from goalwire.entities.pending_call import PendingCall
from goalwire.entities.type_support import service_support
from goalwire.rules.qos import SERVICES_DEFAULT
from goalwire.transport.contract import Endpoint, EndpointKind

WIRES = ('goalwire_memory', 'rmw_zenoh_cpp', 'rmw_cyclonedds_cpp')
IN_FLIGHT = 1000
TIMEOUT_S = 0.05
DOMAIN = '87'
NAME = 'dead'
SUPPORT = service_support(Trigger)


def resident_kib() -> int:
    """Resident memory, of which the C library has given back what it can."""
    gc.collect()
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGESIZE') // 1024


def held() -> int:
    """How many calls any table still holds: those of the client, of its transport, of its context."""
    gc.collect()
    return sum(isinstance(each, PendingCall) for each in gc.get_objects())


class Level:
    """The memory, threads and descriptors of this process at one moment."""

    def __init__(self) -> None:
        self.memory = resident_kib()
        self.threads = threading.active_count()
        self.files = sum(1 for _ in Path('/proc/self/fd').iterdir())

    def since(self, before: Level) -> str:
        """Return the growth since an earlier moment, as text."""
        return (
            f'{self.memory - before.memory:+6d} KiB of {self.memory // 1024} MiB, '
            f'{self.threads - before.threads:+d} threads, {self.files - before.files:+d} files'
        )


def silent(node: NodeCore) -> None:
    """Serve, and never answer."""
    endpoint = Endpoint(
        EndpointKind.SERVICE, f'/{NAME}', SUPPORT.type_name, SUPPORT.type_hash, SERVICES_DEFAULT
    )
    node.port.service(endpoint, lambda _: None)


@contextmanager
def server(wire: str, context: Context) -> Iterator[None]:
    """A server that is silent while the block lasts."""
    if wire == 'goalwire_memory':
        silent(NodeCore(context, 'silent'))
        yield
        return
    with subprocess.Popen(
        [sys.executable, '-m', __spec__.name, '--serve'], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield
        finally:
            process.kill()


def serve() -> None:
    """Be the silent process."""
    with Context() as context:
        silent(NodeCore(context, 'silent'))
        print('ready', flush=True)
        sys.stdin.read()


def futures(client: ClientCore, calls: int) -> Counter[str]:
    """The rclpy front: `call_async`, and futures that nobody spins for."""
    outcomes: Counter[str] = Counter()
    client.call_timeout = TIMEOUT_S
    for _ in range(calls // IN_FLIGHT):
        sent = [client.call_async(Trigger.Request()) for _ in range(IN_FLIGHT)]
        for future in sent:
            future.wait()
            outcomes[type(future.exception()).__name__] += 1
    return outcomes


def coroutines(client: ClientCore, calls: int) -> Counter[str]:
    """The asyncio front: as many tasks as there are calls in flight."""
    from goalwire.aio.services import Client

    outcomes: Counter[str] = Counter()

    async def work(front: Client[Any, Any]) -> None:
        for _ in range(calls // IN_FLIGHT):
            try:
                await front.call(timeout=TIMEOUT_S)
            except Exception as error:
                outcomes[type(error).__name__] += 1

    async def crowd() -> None:
        front: Client[Any, Any] = Client(client.node, SUPPORT, NAME, SERVICES_DEFAULT, None, None)
        async with asyncio.TaskGroup() as group:
            for _ in range(IN_FLIGHT):
                group.create_task(work(front))
        front.close()

    asyncio.run(crowd())
    return outcomes


def measure(wire: str, calls: int) -> None:
    """Print one line for each front, without and with a server."""
    os.environ['RMW_IMPLEMENTATION'] = wire
    for title, there in (('none', False), ('silent', True)):
        for front in (futures, coroutines):
            with Context() as context:
                node = NodeCore(context, 'caller')
                client = ClientCore(node, SUPPORT, NAME, SERVICES_DEFAULT)
                with server(wire, context) if there else nullcontext():
                    assert not there or client.wait_for_service(20.0)
                    report(f'{wire:20} {title:6} {front.__name__:10}', client, front, calls)


def report(title: str, client: ClientCore, front: Any, calls: int) -> None:
    """Make the calls in two halves: by the first everything has grown to its size."""
    front(client, calls // 2)
    before, begun = Level(), time.perf_counter()
    outcomes = front(client, calls // 2)
    rate = calls // 2 / (time.perf_counter() - begun)
    errors = ', '.join(f'{count} {kind}' for kind, count in outcomes.items())
    print(f'{title} {rate:7.0f}/s  {held()} held, {Level().since(before)}; {errors}', flush=True)


def main() -> None:
    """Run what the arguments ask for."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--calls', type=int, default=100_000)
    parser.add_argument('--wire', nargs='*', default=WIRES, choices=WIRES)
    parser.add_argument('--serve', action='store_true', help=argparse.SUPPRESS)
    given = parser.parse_args()
    os.environ['ROS_DOMAIN_ID'] = DOMAIN
    if given.serve:
        serve()
        return
    for wire in given.wire:
        measure(wire, given.calls)


if __name__ == '__main__':
    main()
