"""How the programs of the benchmark spin: by rclpy's functions, or an executor that the environment names.

Runs under the real rclpy too, so rclpy is not imported before it is needed.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from importlib import import_module
from threading import Event, Thread
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar

if TYPE_CHECKING:
    from rclpy.executors import Executor
    from rclpy.node import Node
    from rclpy.task import Future

PATIENCE_S = 20.0
"""How long anything may take to begin; only failures take that long."""
WAKE_S = 0.2
"""How often a loop of `spin_once` looks whether it is to end."""

SPIN_ONCE = 'BENCHMARK_SPIN_ONCE'
"""Set for the real rclpy. There `spin_once` in a loop stands in for two functions.

In 7.1.6 each `spin_until_future_complete` leaves tasks behind that the next one has to work off, one more
every time: the thousandth call takes 16 ms. And up to 9.1.2 `EventsExecutor.spin` answers nothing.
"""
_SPINS_ONCE = SPIN_ONCE in os.environ

EXECUTOR = 'BENCHMARK_EXECUTOR'
"""Module and class of the executor that spins: `rclpy.experimental:EventsExecutor`. Unset: rclpy chooses."""
_EXECUTOR = os.environ.get(EXECUTOR, '')

_HAS_WORKERS = _EXECUTOR.endswith(':MultiThreadedExecutor')

T = TypeVar('T')

_executors: dict[Node, Executor] = {}


def _make_executor(otherwise: str) -> Executor:
    module, _, name = (_EXECUTOR or otherwise).partition(':')
    executor: Executor = getattr(import_module(module), name)()
    return executor


def _executor_of(node: Node) -> Executor | None:
    """Return the executor that spins a node; None if rclpy's own functions choose it."""
    if not _EXECUTOR:
        return None
    if node not in _executors:
        _executors[node] = _make_executor(_EXECUTOR)
        _executors[node].add_node(node)
    return _executors[node]


def spin_once(node: Node, timeout_sec: float = PATIENCE_S) -> None:
    """Do what rclpy.spin_once does."""
    import rclpy

    executor = _executor_of(node)
    if executor is None:
        rclpy.spin_once(node, timeout_sec=timeout_sec)
    else:
        executor.spin_once(timeout_sec=timeout_sec)


def spin_until_done(node: Node, future: Future[Any], timeout: float | None = None) -> None:
    """Do what rclpy.spin_until_future_complete does."""
    import rclpy

    if not _SPINS_ONCE:
        rclpy.spin_until_future_complete(node, future, _executor_of(node), timeout)
        return
    end = perf_counter() + (PATIENCE_S if timeout is None else timeout)
    while not future.done() and (left := end - perf_counter()) > 0:
        spin_once(node, left)


class Arrivals(list[T]):
    """The messages that have come. With workers, `spin_once` returns before the callback has run."""

    def __init__(self) -> None:
        super().__init__()
        self._next: Future[None] | None = None

    def append(self, message: T) -> None:
        super().append(message)
        if self._next is not None:
            self._next.set_result(None)

    def spin_until_next(self, node: Node) -> None:
        """Spin until something has come."""
        from rclpy.task import Future

        self._next = Future()
        if not self:  # looked at after `_next` was set, since `append` acts in opposite order
            spin_until_done(node, self._next, PATIENCE_S)
        self._next = None


def arrivals() -> list[Any]:
    """Return the list for `spin_until_any`, whose `append` is the callback of a subscription."""
    return Arrivals() if _HAS_WORKERS else []


def spin_until_any(node: Node, received: list[Any]) -> None:
    """Spin until there is something in `received`, of `arrivals`; ends the program if nothing comes."""
    end = perf_counter() + PATIENCE_S
    while not received:
        if perf_counter() > end:
            sys.exit(f'what was sent did not come back within {PATIENCE_S:.0f} s')
        if isinstance(received, Arrivals):
            received.spin_until_next(node)
        else:
            spin_once(node, PATIENCE_S)


def spin(node: Node) -> None:
    """Do what rclpy.spin does, until rclpy is shut down."""
    import rclpy
    from rclpy.executors import ExternalShutdownException

    executor = _executor_of(node)
    with suppress(ExternalShutdownException):
        if executor is None:
            rclpy.spin(node)
        elif not _SPINS_ONCE:
            executor.spin()
        else:
            while rclpy.ok():
                executor.spin_once(timeout_sec=WAKE_S)


class BackgroundSpin:
    """Spins a node on a thread of its own while the block runs."""

    def __init__(self, node: Node) -> None:
        self._executor = _make_executor('rclpy.executors:SingleThreadedExecutor')
        self._executor.add_node(node)
        self._ended = Event()
        self._thread = Thread(target=self._spin)

    def _spin(self) -> None:
        if not (_EXECUTOR and _SPINS_ONCE):
            self._executor.spin()
        while not self._ended.is_set():
            self._executor.spin_once(timeout_sec=WAKE_S)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        if not (_EXECUTOR and _SPINS_ONCE):
            self._executor.shutdown()
        self._thread.join()
