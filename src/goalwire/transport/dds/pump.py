"""A thread that waits for many conditions at once and calls who waits for them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from ctypes import c_ssize_t
from itertools import count

from goalwire.transport.dds.abi import INFINITY
from goalwire.transport.dds.wire import Participant, check
from goalwire.transport.failures import report_failure

_AT_ONCE = 64
_WAKE_UP = 0
CLOSING_S = 5.0
"""How long closing waits for what the thread is at."""


class Pump:
    """One waitset and its thread, which starts with the first condition."""

    def __init__(self, participant: Participant, name: str) -> None:
        self._library = participant.library
        self._name = name
        self._lock = threading.Lock()
        self._handlers: dict[int, tuple[int, Callable[[], None]]] = {}
        self._keys: dict[int, int] = {}
        self._next_key = count(_WAKE_UP + 1).__next__
        self._woken: Callable[[], None] | None = None
        self._alarm: tuple[int, Callable[[], None]] | None = None
        self._stopping = False
        self._thread: threading.Thread | None = None
        self._set = check(self._library, self._library.dds_create_waitset(participant.handle), name)
        self._guard = check(self._library, self._library.dds_create_guardcondition(participant.handle), name)
        self._library.dds_waitset_attach(self._set, self._guard, _WAKE_UP)

    def watch(self, condition: int, handler: Callable[[], None]) -> None:
        """Call `handler` while the condition, or the entity's status, is true; `unwatch` ends that."""
        key = self._next_key()
        with self._lock:
            self._handlers[key] = condition, handler
            self._keys[condition] = key
            if self._thread is None and not self._stopping:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()
        check(self._library, self._library.dds_waitset_attach(self._set, condition, key), self._name)

    def unwatch(self, condition: int) -> None:
        """Call no more for this condition; an unknown one is no error."""
        with self._lock:
            key = self._keys.pop(condition, None)
            if key is not None:
                del self._handlers[key]
        if key is not None:
            self._library.dds_waitset_detach(self._set, condition)

    def on_wake(self, handler: Callable[[], None]) -> None:
        """Call `handler` on the thread after each `wake`."""
        self._woken = handler

    def wake(self) -> None:
        """Have the thread call who asked for it; several calls may count as one."""
        self._library.dds_set_guardcondition(self._guard, True)

    def alarm(self, delay_ns: int, handler: Callable[[], None]) -> None:
        """Call `handler` once, in `delay_ns`; only for what the thread itself calls."""
        self._alarm = time.monotonic_ns() + delay_ns, handler

    def close(self) -> None:
        """End the thread and wait for it, unless this is it."""
        with self._lock:
            self._stopping = True
            thread = self._thread
        self.wake()
        if thread is not None and thread is not threading.current_thread():
            thread.join(CLOSING_S)

    def _run(self) -> None:
        library, triggered = self._library, (c_ssize_t * _AT_ONCE)()
        wait, handlers = library.dds_waitset_wait, self._handlers
        while not self._stopping:
            alarm = self._alarm
            patience = INFINITY if alarm is None else max(alarm[0] - time.monotonic_ns(), 0)
            found = wait(self._set, triggered, _AT_ONCE, patience)
            if found < 0:
                return  # the participant has gone
            for index in range(min(found, _AT_ONCE)):
                key = triggered[index]
                if key == _WAKE_UP:
                    self._wake_up()
                elif (entry := handlers.get(key)) is not None:
                    self._call(entry[1])

            if alarm is not None and time.monotonic_ns() >= alarm[0]:
                self._alarm = None
                self._call(alarm[1])

    def _wake_up(self) -> None:
        if self._stopping:
            return
        self._library.dds_set_guardcondition(self._guard, False)
        if self._woken is not None:
            self._call(self._woken)

    def _call(self, handler: Callable[[], None]) -> None:
        try:
            handler()
        except Exception as error:
            report_failure(self._name, error)
