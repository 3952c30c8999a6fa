"""A thread that waits for many conditions at once and calls who waits for them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from goalwire.transport.dds.abi import INFINITY
from goalwire.transport.dds.waitset import WaitSet
from goalwire.transport.dds.wire import Participant
from goalwire.transport.reports import report_failure

CLOSING_S = 5.0
"""How long closing waits for what the thread is at."""


class WaitsetThread:
    """One waitset and its thread, which starts with the first condition."""

    def __init__(self, participant: Participant, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._woken: Callable[[], None] | None = None
        self._timed_call: tuple[int, Callable[[], None]] | None = None
        self._stopping = False
        self._thread: threading.Thread | None = None
        self._set = WaitSet(participant, name)
        self._set.on_interrupt = self._wake_up
        self.unwatch = self._set.unwatch

    def watch(self, condition: int, handler: Callable[[], None]) -> None:
        """Call `handler` while the condition, or the entity's status, is true; `unwatch` ends that."""
        with self._lock:
            if self._thread is None and not self._stopping:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()
        self._set.watch(condition, handler)

    def on_wake(self, handler: Callable[[], None]) -> None:
        """Call `handler` on the thread after each `wake`."""
        self._woken = handler

    def wake(self) -> None:
        """Have the thread call who asked for it; several calls may count as one."""
        self._set.interrupt()

    def call_in(self, delay_ns: int, handler: Callable[[], None]) -> None:
        """Call `handler` once, in `delay_ns`; only for what the thread itself calls."""
        self._timed_call = time.monotonic_ns() + delay_ns, handler

    def close(self) -> None:
        """End the thread and wait for it, unless this is it."""
        with self._lock:
            self._stopping = True
            thread = self._thread
        self.wake()
        if thread is not None and thread is not threading.current_thread():
            thread.join(CLOSING_S)

    def _run(self) -> None:
        while not self._stopping:
            call_in = self._timed_call
            patience = INFINITY if call_in is None else max(call_in[0] - time.monotonic_ns(), 0)
            found = self._set.wait(patience)
            if found < 0:
                return
            self._set.serve(found)
            if call_in is not None and time.monotonic_ns() >= call_in[0]:
                self._timed_call = None
                self._call(call_in[1])

    def _wake_up(self) -> None:
        if self._woken is not None and not self._stopping:
            self._call(self._woken)

    def _call(self, handler: Callable[[], None]) -> None:
        try:
            handler()
        except Exception as error:
            report_failure(self._name, error)
