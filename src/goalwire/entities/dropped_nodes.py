"""Closes a node that a program drops without destroying it, so that it leaves the graph.

Python's garbage collector finds such a node, since nothing but the node holds its entities (weak_methods.py).
It may do so on any thread, in the middle of any code, which may hold a lock. So another thread closes the
node's parts.
"""

from __future__ import annotations

from _thread import start_new_thread
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import TYPE_CHECKING

from goalwire.fault_reports import report_failure

if TYPE_CHECKING:
    from goalwire.transport.contract import NodePort


class Remains:
    """The clean-up steps that end one node. They must not refer to the node, nor to anything that does."""

    def __init__(self, port: NodePort) -> None:
        self._port = port
        self._steps: dict[Callable[[], object], None] = {}

    def add(self, step: Callable[[], object]) -> None:
        """Add a step of the clean-up that follows if the program drops the node."""
        self._steps[step] = None

    def discard(self, step: Callable[[], object]) -> None:
        """Remove a step that was carried out already, or that is not needed any more."""
        self._steps.pop(step, None)

    def close_soon(self) -> None:
        """Take everything off the wire, on a thread of its own. Takes no lock: a finalizer calls it."""
        with suppress(RuntimeError):  # the interpreter is ending, and closes all sessions
            start_new_thread(self._start, ())

    def _start(self) -> None:
        with suppress(RuntimeError):
            Thread(target=self._close, name='goalwire-dropped-node', daemon=True).start()

    def _close(self) -> None:
        for step in [*reversed(self._steps), self._port.close]:
            try:
                step()
            except Exception as error:
                report_failure('the end of a node that was dropped', error)
