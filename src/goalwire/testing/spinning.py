"""Spins a node under test in a thread, as the node's own process would."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from goalwire.errors import ExternalShutdownException
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.execution.executors.executor import Executor

GRACE_S = 5.0
"""The time in s that `close` waits for a running callback to end."""


class Hosted:
    """The part of a node that an executor needs."""

    def __init__(self, core: NodeCore) -> None:
        self.handle = core
        self.executor: Any = None


class Spinning:
    """Spins `node` until `close`. Errors of the node's callbacks are kept in `raised`, and spinning
    goes on.
    """

    def __init__(self, name: str, node: Any, executor: Executor) -> None:
        self.name = name
        self.node = node
        self.raised: list[BaseException] = []
        self._executor = executor
        self._closing = False
        executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name=f'spin {name}', daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        while not self._closing and self._executor.context.ok():
            try:
                self._executor.spin()
            except ExternalShutdownException:
                return
            except BaseException as error:
                self.raised.append(error)

    def close(self) -> bool:
        """Stop spinning and wait for the thread; return False if a callback does not end."""
        self._closing = True
        self._executor.shutdown()
        if self._thread is not threading.current_thread():
            self._thread.join(GRACE_S)
        return not self._thread.is_alive()


def host(core: NodeCore) -> Spinning:
    """Spin one of the graph's own nodes."""
    executor = SingleThreadedExecutor(context=core.context)
    return Spinning(core.name.qualified, Hosted(core), executor)
