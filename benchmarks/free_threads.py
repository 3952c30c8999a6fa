"""How much faster callbacks that compute run on two threads than on one: python -m benchmarks.free_threads.

Four timers, each in a callback group of its own, compute on a MultiThreadedExecutor. The same work in bare
threads stands beside them, and shows what the interpreter and the machine allow. With the global interpreter
lock two threads take as long as one; without it, and with two idle processors, half as long.
"""

from __future__ import annotations

import os
import sys
import threading
import time
import warnings
from collections.abc import Callable
from statistics import median

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

CALLBACKS = 4
CALLS = 25
"""How often each of the four computes in one measurement."""
STEPS = 60_000
"""How long a callback computes: about 2 ms."""
PERIOD_S = 0.0001
"""The timers' period. It is shorter than a callback, so all four are due at any time."""
THREADS = (1, 2, 4)
ROUNDS = 5


def compute() -> int:
    """Compute with numbers up to 256 alone, which threads share at no cost.

    References to larger constants of an imported module are counted in CPython 3.13, and two threads that
    count references to one object are slower than one thread.
    """
    value = 1
    for _ in range(STEPS):
        value = (value * 5 + 3) & 63
    return value


def run_bare(threads: int) -> float:
    """Return how many s bare threads take."""

    def run() -> None:
        for _ in range(CALLBACKS * CALLS // threads):
            compute()

    members = [threading.Thread(target=run) for _ in range(threads)]
    begun = time.perf_counter()
    for member in members:
        member.start()
    for member in members:
        member.join()
    return time.perf_counter() - begun


class Worker:
    """A timer that computes `CALLS` times, and then completes a future."""

    def __init__(self, node: Node) -> None:
        self.done: Future[None] = Future()
        self._left = CALLS
        self._timer = node.create_timer(PERIOD_S, self._work, MutuallyExclusiveCallbackGroup())

    def _work(self) -> None:
        compute()
        self._left -= 1
        if not self._left:
            self._timer.cancel()
            self.done.set_result(None)


def run_executor(threads: int) -> float:
    """Return how many s the callbacks of an executor take."""
    node = rclpy.create_node('bench_free_threads')
    with warnings.catch_warnings(action='ignore'):  # of the executor with a single thread
        executor = MultiThreadedExecutor(threads)
    executor.add_node(node)
    workers = [Worker(node) for _ in range(CALLBACKS)]
    begun = time.perf_counter()
    for worker in workers:
        executor.spin_until_future_complete(worker.done)
    took = time.perf_counter() - begun
    executor.shutdown()
    node.destroy_node()
    return took


WAYS: dict[str, Callable[[int], float]] = {'bare threads': run_bare, 'MultiThreadedExecutor': run_executor}


def main() -> None:
    """Measure all in turn, and print a table."""
    os.environ.setdefault('RMW_IMPLEMENTATION', 'goalwire_memory')
    rclpy.init()
    found: dict[str, list[list[float]]] = {way: [] for way in WAYS}
    for _ in range(ROUNDS):
        for way, run in WAYS.items():
            found[way].append([run(threads) for threads in THREADS])
    is_locked = getattr(sys, '_is_gil_enabled', lambda: True)()
    print(f'Python {sys.version.split()[0]}, {"with" if is_locked else "without"} a global interpreter lock')
    print('| ms |', ' | '.join(f'{threads} thread{"s" * (threads > 1)}' for threads in THREADS), '| 2 of 1 |')
    print('|---|' + '---|' * (len(THREADS) + 1))
    for way, rounds in found.items():
        times = [median(column) * 1e3 for column in zip(*rounds, strict=True)]
        print(f'| {way} |', ' | '.join(f'{took:.0f}' for took in times), f'| {times[1] / times[0]:.2f} |')
    rclpy.shutdown()


if __name__ == '__main__':
    main()
