"""An executor that spins on a thread of its own while a test acts, and futures waited for with a deadline."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self, TypeAlias, TypeVar

from helpers.collector import Collector
from helpers.patience import PATIENCE
from rclpy.node import Node

from goalwire.entities.context import Context
from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.execution.executors.executor import Executor, ExternalShutdownException
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import STEADY

T = TypeVar('T')

MakeNode: TypeAlias = Callable[..., Node]
Spin: TypeAlias = 'Callable[..., Spinner]'


class Spinner:
    """Spins `executor` until closed. What comes out of spin is collected, and spinning goes on."""

    def __init__(self, executor: Executor, *nodes: Any) -> None:
        self.executor = executor
        self.raised: Collector[BaseException] = Collector()
        for node in nodes:
            executor.add_node(node)
        self._closing = False
        self._thread = threading.Thread(target=self._spin, name='test-spinner')
        self._thread.start()

    def _spin(self) -> None:
        while not self._closing and self.executor.context.ok():
            try:
                self.executor.spin()
            except ExternalShutdownException:
                return
            except BaseException as error:
                self.raised(error)

    def close(self) -> None:
        """End the spin and wait for its thread."""
        self._closing = True
        self.executor.shutdown()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive(), 'spin did not end'

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
        if kind is None:
            assert self.raised.items == [], 'came out of spin and was not looked at'

    def expect_raised(self, kind: type[BaseException]) -> BaseException:
        """Wait for one exception out of spin, insist on its type, and forget it."""
        found = self.raised.expect(1, PATIENCE)
        assert len(found) == 1
        assert isinstance(found[0], kind), found[0]
        self.raised = Collector()
        return found[0]


def result_of(future: Future[T], timeout: float = PATIENCE) -> T:
    """Wait for a future on this thread and return its result; fail when it stays pending."""
    assert future.wait(STEADY.now() + int(timeout * 1e9)), f'still pending after {timeout} s'
    assert not future.cancelled()
    result = future.result()
    assert result is not None
    return result


def wait_until(context: Context, predicate: Callable[[], bool]) -> None:
    """Wait until the graph looks as `predicate` wants it."""
    assert wait_for_graph(context, predicate, PATIENCE), 'the graph never looked like that'
