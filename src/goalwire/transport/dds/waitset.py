"""Waiting for many conditions at once, and for a word from another thread."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import addressof, c_ssize_t
from functools import partial
from itertools import count
from threading import Lock

from goalwire.transport.dds.wire import Participant, check
from goalwire.transport.reports import report_failure

_AT_ONCE = 64
_INTERRUPTED = 0


class WaitSet:
    """The conditions of one participant and who is told of them. One thread at a time waits here."""

    def __init__(self, participant: Participant, name: str) -> None:
        self.on_interrupt: Callable[[], None] | None = None
        """Called by the waiting thread after each `interrupt`."""
        self._library = participant.library
        self._name = name
        self._lock = Lock()
        self._handlers: dict[int, Callable[[], object]] = {_INTERRUPTED: self._interrupted}
        self._keys: dict[int, int] = {}
        self._next_key = count(_INTERRUPTED + 1).__next__
        self._triggered = (c_ssize_t * _AT_ONCE)()
        self._set = check(self._library, self._library.dds_create_waitset(participant.handle), name)
        self._guard = check(self._library, self._library.dds_create_guardcondition(participant.handle), name)
        self._library.dds_waitset_attach(self._set, self._guard, _INTERRUPTED)
        self.wait: Callable[[int], int] = partial(
            self._library.dds_waitset_wait, self._set, addressof(self._triggered), _AT_ONCE
        )
        """Returns how many conditions are true in so many ns; negative once the participant has gone."""

    def watch(self, condition: int, handler: Callable[[], object]) -> None:
        """Call `handler` while the condition, or the entity's status, is true; `unwatch` ends that."""
        key = self._next_key()
        with self._lock:
            self._handlers[key] = handler
            self._keys[condition] = key
        check(self._library, self._library.dds_waitset_attach(self._set, condition, key), self._name)

    def unwatch(self, condition: int) -> None:
        """Call no more for this condition; an unknown one is no error."""
        with self._lock:
            key = self._keys.pop(condition, None)
            if key is not None:
                del self._handlers[key]
        if key is not None:
            self._library.dds_waitset_detach(self._set, condition)

    def interrupt(self) -> None:
        """End the current `wait`, or else the next; several count as one. Any thread."""
        self._library.dds_set_guardcondition(self._guard, True)

    def serve(self, found: int) -> None:
        """Call the handlers of the `found` conditions; what they raise is reported."""
        for key in self._triggered[:found]:  # _AT_ONCE of them at most, as any slice
            handler = self._handlers.get(key)
            if handler is not None:
                try:
                    handler()
                except Exception as error:
                    report_failure(self._name, error)

    def _interrupted(self) -> None:
        self._library.dds_set_guardcondition(self._guard, False)
        if self.on_interrupt is not None:
            self.on_interrupt()
