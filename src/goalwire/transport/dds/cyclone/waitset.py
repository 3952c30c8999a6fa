"""Waits for many DDS conditions at once; another thread can end the wait.

A session has two of these. In one, for its readers, an idle thread of the program waits (Leader/Followers).
In the other, for discovery and statuses, a thread of its own waits.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from ctypes import addressof, c_ssize_t
from functools import partial
from itertools import count
from threading import Lock

from goalwire.concurrency.leader_followers import LeaderFollowers
from goalwire.concurrency.threads import begin, join_begun
from goalwire.fault_reports import report_failure
from goalwire.transport.dds.cyclone.abi import INFINITY
from goalwire.transport.dds.cyclone.wire import Participant, check

_AT_ONCE = 64
_INTERRUPTED = 0


class WaitSet:
    """The conditions of one participant, with their callbacks. One thread at a time waits here."""

    awaited = ()
    """Empty: a waitset cannot tell which condition is likely to be the next (see WireSet)."""

    def __init__(self, participant: Participant, name: str) -> None:
        self.on_interrupt: Callable[[], None] | None = None
        """Called by the waiting thread after each `interrupt`."""
        self._library = participant.library
        self._name = name
        self._lock = Lock()
        self._handlers: dict[int, Callable[[], object]] = {_INTERRUPTED: self._on_interrupt}
        self._keys: dict[int, int] = {}
        self._next_key = count(_INTERRUPTED + 1).__next__
        self._triggered = (c_ssize_t * _AT_ONCE)()
        self._set = check(self._library, self._library.dds_create_waitset(participant.handle), name)
        self._guard = check(self._library, self._library.dds_create_guardcondition(participant.handle), name)
        self._library.dds_waitset_attach(self._set, self._guard, _INTERRUPTED)
        self.wait: Callable[[int], int] = partial(
            self._library.dds_waitset_wait, self._set, addressof(self._triggered), _AT_ONCE
        )
        """The library's wait. It takes ns and returns how many conditions are true, a negative number once
        the participant has been deleted."""

    def watch(self, condition: int, handler: Callable[[], object]) -> None:
        """Call `handler` whenever the condition or the entity's status is true, until `unwatch`."""
        key = self._next_key()
        with self._lock:
            self._handlers[key] = handler
            self._keys[condition] = key
        check(self._library, self._library.dds_waitset_attach(self._set, condition, key), self._name)

    def unwatch(self, condition: int) -> None:
        """Stop watching this condition; an unknown one is ignored."""
        with self._lock:
            key = self._keys.pop(condition, None)
            if key is not None:
                del self._handlers[key]
        if key is not None:
            self._library.dds_waitset_detach(self._set, condition)

    def descriptor(self) -> int | None:
        """None: a waitset has no descriptor."""
        return None

    def next_due(self) -> float:
        """Return infinity: there are no timers."""
        return float('inf')

    def interrupt(self) -> None:
        """End the current or the next `wait`. Several calls may count as one. Any thread."""
        self._library.dds_set_guardcondition(self._guard, True)

    def serve(self, found: int) -> None:
        """Call the handlers of the `found` conditions, and log their errors."""
        # The slice ends at _AT_ONCE even if more conditions are true.
        for key in self._triggered[:found]:
            handler = self._handlers.get(key)
            if handler is not None:
                try:
                    handler()
                except Exception as error:
                    report_failure(self._name, error)

    def _on_interrupt(self) -> None:
        self._library.dds_set_guardcondition(self._guard, False)
        if self.on_interrupt is not None:
            self.on_interrupt()


CLOSING_S = 5.0
"""How long closing waits for a handler that runs on the thread."""


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
        """Call `handler` whenever the condition or the entity's status is true, until `unwatch`."""
        with self._lock:
            if self._thread is None and not self._stopping:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                begin(self._thread)
        self._set.watch(condition, handler)

    def on_wake(self, handler: Callable[[], None]) -> None:
        """Call `handler` on the thread after each `wake`."""
        self._woken = handler

    def wake(self) -> None:
        """Make the thread call the handler of `on_wake`. Several calls may count as one."""
        self._set.interrupt()

    def call_in(self, delay_ns: int, handler: Callable[[], None]) -> None:
        """Call `handler` once, in `delay_ns`. Only handlers on the thread itself may call this."""
        self._timed_call = time.monotonic_ns() + delay_ns, handler

    def close(self) -> None:
        """End the thread, and wait for it unless it is the calling thread."""
        with self._lock:
            self._stopping = True
            thread = self._thread
        self.wake()
        if thread is not None and thread is not threading.current_thread():
            join_begun(thread, CLOSING_S)

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


class DdsWirePoller(LeaderFollowers):
    """The waitset of one session's readers, and the threads that wait in it."""

    def __init__(self, participant: Participant, name: str) -> None:
        self._conditions = WaitSet(participant, name)
        super().__init__(self._conditions, name)

    def watch(self, condition: int, handler: Callable[[], object]) -> None:
        """Call `handler` on the waiting thread whenever the condition is true, until `unwatch`."""
        self.start()
        self._conditions.watch(condition, handler)

    def unwatch(self, condition: int) -> None:
        """Stop watching this condition; an unknown one is ignored."""
        self._conditions.unwatch(condition)
