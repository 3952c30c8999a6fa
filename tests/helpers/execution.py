"""A context and a node as small as the execution core allows."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Self

from helpers.patience import PATIENCE

from goalwire.execution.executors.executor import Executor
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.execution.shutdown_signal import ShutdownSignal


class SmallContext:
    """A shutdown signal."""

    def __init__(self) -> None:
        self.shutdown_signal = ShutdownSignal()

    def ok(self) -> bool:
        return self.shutdown_signal.alive

    def shutdown(self) -> None:
        self.shutdown_signal.end('shutdown')


class SmallNode:
    """A home."""

    def __init__(self) -> None:
        self.work_queue = NodeWorkQueue()
        self.executor: Any = None

    @property
    def handle(self) -> Self:
        return self


class Spinning:
    """Lets `executor` spin in a thread of its own while the block lasts; `error` is what spin raised."""

    def __init__(self, executor: Executor, spin: Callable[[], object] | None = None) -> None:
        self._executor = executor
        self._spin = spin or executor.spin
        self.error: BaseException | None = None
        self.ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name='spinning')

    def _run(self) -> None:
        try:
            self._spin()
        except BaseException as error:
            self.error = error
        finally:
            self.ended.set()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive(), 'spin did not end'
