"""The two processes of a measured program: one asks and measures, its partner answers.

Runs under the real rclpy too, so nothing here imports goalwire, or rclpy before it is needed.

A program is a module with `ask(count) -> Figures` and `answer()`; `python -m MODULE ask COUNT` starts the
partner by itself, on the same interpreter and environment, and prints the figures as JSON.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from threading import Thread
from time import perf_counter, process_time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from benchmarks.line import Figures
from benchmarks.spinning import PATIENCE_S, spin

if TYPE_CHECKING:
    from rclpy.node import Node

WARM_UP = 100
PINNED = 'BENCHMARK_PINNED'
"""Two processors, of the asking process and of its partner. Unset: wherever the system puts them."""

Commands = Mapping[str, Callable[..., object]]


def run(ask: Callable[..., Figures], answer: Callable[..., None]) -> None:
    """Play the part that the command line names, with its other arguments."""
    arguments = [int(text) if text.isdecimal() else text for text in sys.argv[2:]]
    asks = sys.argv[1] == 'ask'
    if PINNED in os.environ:
        here, there = map(int, os.environ[PINNED].split(','))
        os.sched_setaffinity(0, {here if asks else there})
    if asks:
        print(json.dumps(ask(*arguments)))
    else:
        answer(*arguments)


class Partner:
    """The answering process of `module`, until the block ends."""

    def __init__(self, module: str, *arguments: object) -> None:
        command = [sys.executable, '-m', module, 'answer', *map(str, arguments)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.pid = self._process.pid
        self.result()

    def order(self, command: str, *arguments: int) -> None:
        """Give an order; the outcome is fetched with `result`."""
        assert self._process.stdin is not None
        self._process.stdin.write(' '.join([command, *map(str, arguments)]) + '\n')
        self._process.stdin.flush()

    def result(self) -> float:
        """Wait for the outcome of the last order."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            sys.exit('the partner of this benchmark ended early')
        return float(line)

    def do(self, command: str, *arguments: int) -> float:
        """Give an order and wait for its outcome."""
        self.order(command, *arguments)
        return self.result()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()  # ends it
        self._process.stdout.close()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def obey(commands: Commands) -> None:
    """Say that this process is ready, then follow orders until its standard input ends."""
    print(0, flush=True)
    known = {'cpu': process_time, **commands}
    for line in sys.stdin:
        name, *arguments = line.split()
        outcome = known[name](*map(int, arguments))
        print(outcome if isinstance(outcome, (int, float)) else 0, flush=True)


def serve(node: Node) -> None:
    """Spin a node until the asking process ends this one."""
    import rclpy

    def follow() -> None:
        obey({})
        rclpy.try_shutdown()

    thread = Thread(target=follow)
    thread.start()
    spin(node)
    thread.join()
    node.destroy_node()


class Meter:
    """CPU used from now on, by this process and its partner."""

    def __init__(self, partner: Partner | None = None) -> None:
        self._partner = partner
        self._there = partner.do('cpu') if partner else 0.0
        self._here = process_time()

    def read(self, operations: int) -> Figures:
        """Return what an operation cost, in µs."""
        here = (process_time() - self._here) / operations * 1e6
        if self._partner is None:
            return {'cpu': here, 'cpu_here': here}
        there = (self._partner.do('cpu') - self._there) / operations * 1e6
        return {'cpu': here + there, 'cpu_here': here, 'cpu_there': there}


class Stopwatch:
    """Seconds from now on."""

    def __init__(self) -> None:
        self._begun = perf_counter()

    def read(self) -> float:
        return perf_counter() - self._begun


def quantiles(times: list[float]) -> Figures:
    """Return median and 99th percentile of times in seconds, as µs."""
    ordered = sorted(times)
    return {
        'p50': ordered[len(ordered) // 2] * 1e6,
        'p99': ordered[min(int(len(ordered) * 0.99), len(ordered) - 1)] * 1e6,
    }


def round_trips(exchange: Callable[[], object], count: int, partner: Partner) -> Figures:
    """Time `count` exchanges, one after the other, after a warm-up."""
    for _ in range(WARM_UP):
        exchange()
    meter = Meter(partner)
    times = []
    for _ in range(count):
        begun = perf_counter()
        exchange()
        times.append(perf_counter() - begun)
    return meter.read(count) | quantiles(times)


async def awaited(exchange: Callable[[], Awaitable[object]], count: int, partner: Partner) -> Figures:
    """Time `count` exchanges that are awaited, one after the other, after a warm-up."""
    for _ in range(WARM_UP):
        await exchange()
    meter = Meter(partner)
    times = []
    for _ in range(count):
        begun = perf_counter()
        await exchange()
        times.append(perf_counter() - begun)
    return meter.read(count) | quantiles(times)


def reported(exchange: Callable[[], float], count: int, partner: Partner) -> Figures:
    """Collect the seconds that `count` exchanges report, after a warm-up."""
    for _ in range(WARM_UP // 5):
        exchange()
    meter = Meter(partner)
    times = [exchange() for _ in range(count)]
    return meter.read(count) | quantiles(times)
