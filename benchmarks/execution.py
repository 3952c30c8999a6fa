"""The cost of the execution core itself: run `python benchmarks/execution.py`. Medians of five rounds.

Times are of the whole process (CPU) if a thread is handed something, and of the thread otherwise.
"""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable
from typing import Self

from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.clock import Clock
from goalwire.execution.time.timer import Timer
from goalwire.rules.time import ClockType

ROUNDS = 5


class Context:
    def __init__(self) -> None:
        self.shutdown_signal = ShutdownSignal()

    def ok(self) -> bool:
        return self.shutdown_signal.alive


class Node:
    def __init__(self) -> None:
        self.work_queue = NodeWorkQueue()
        self.executor: object = None

    @property
    def handle(self) -> Self:
        return self


def deliver(_executor: Executor, node: Node) -> float:
    """µs for a transport thread to queue one message."""
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, lambda _: None)
    begun = time.thread_time_ns()
    for number in range(100_000):
        event_queue.deliver(number)
    return (time.thread_time_ns() - begun) / 1e8


def message(executor: Executor, node: Node) -> float:
    """µs for the executor to run one plain callback, of 100,000 that wait."""
    count = 100_000
    done: Future[int] = Future()

    def take(number: int) -> None:
        if number == count - 1:
            done.set_result(1)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, MutuallyExclusiveCallbackGroup(), take)
    for number in range(count):
        event_queue.deliver(number)
    begun = time.process_time_ns()
    executor.spin_until_future_complete(done)
    return (time.process_time_ns() - begun) / count / 1e3


def coroutine(executor: Executor, node: Node) -> float:
    """µs for one coroutine callback, of 20,000 that wait."""
    count = 20_000
    done: Future[int] = Future()

    async def take(number: int) -> None:
        if number == count - 1:
            done.set_result(1)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, MutuallyExclusiveCallbackGroup(), take)
    for number in range(count):
        event_queue.deliver(number)
    begun = time.process_time_ns()
    executor.spin_until_future_complete(done)
    return (time.process_time_ns() - begun) / count / 1e3


def post_to_run(executor: Executor, node: Node) -> float:
    """µs from a delivery on another thread to the callback on a sleeping executor (median of 2000)."""
    taken: list[int] = []
    step = threading.Semaphore(0)

    def take(sent: int) -> None:
        taken.append(time.perf_counter_ns() - sent)
        step.release()

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, take)
    stop: Future[None] = Future()
    thread = threading.Thread(target=executor.spin_until_future_complete, args=(stop,))
    thread.start()
    for _ in range(2000):
        event_queue.deliver(time.perf_counter_ns())
        step.acquire()
    stop.set_result(None)
    thread.join()
    return statistics.median(taken) / 1e3


def timer_tick(executor: Executor, node: Node) -> float:
    """µs CPU for one tick of a 1 kHz timer, nothing else going on."""
    ticks = 1000
    done: Future[None] = Future()
    count = 0

    def tick() -> None:
        nonlocal count
        count += 1
        if count == ticks:
            done.set_result(None)

    timer = Timer(tick, None, 1_000_000, Clock(clock_type=ClockType.STEADY_TIME), work_queue=node.work_queue)
    begun = time.process_time_ns()
    executor.spin_until_future_complete(done)
    timer.destroy()
    return (time.process_time_ns() - begun) / ticks / 1e3


def spin_once(executor: Executor, _node: Node) -> float:
    """µs for one spin_once(timeout_sec=0) with nothing to do."""
    begun = time.process_time_ns()
    for _ in range(20_000):
        executor.spin_once(timeout_sec=0)
    return (time.process_time_ns() - begun) / 2e7


MEASURES: list[Callable[[Executor, Node], float]] = [
    deliver, message, coroutine, post_to_run, timer_tick, spin_once,
]  # fmt: skip


def measure(what: Callable[[Executor, Node], float], kind: Callable[[Context], Executor]) -> float:
    rounds = []
    for _ in range(ROUNDS):
        node = Node()
        with kind(Context()) as executor:
            executor.add_node(node)
            rounds.append(what(executor, node))
    return statistics.median(rounds)


def main() -> None:
    print(f'{"µs":14} {"single":>8} {"multi":>8}')
    for what in MEASURES:
        single = measure(what, lambda context: SingleThreadedExecutor(context=context))
        multi = measure(what, lambda context: MultiThreadedExecutor(4, context=context))
        print(f'{what.__name__:14} {single:8.2f} {multi:8.2f}   {(what.__doc__ or "").strip()}')


if __name__ == '__main__':
    main()
