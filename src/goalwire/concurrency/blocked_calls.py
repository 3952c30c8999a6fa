"""Threads that block in a call until a condition holds, and wait on the wire meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from goalwire.concurrency.wire_poller import SleepingThread, WirePoller

LONGEST_S = 1e6
"""The longest single sleep, in s; the timeout of a lock has an upper limit."""


class BlockedCalls:
    """The threads that wait for a session to change."""

    def __init__(self, wire_poller: WirePoller) -> None:
        self._wire_poller = wire_poller
        self._sleepers: set[SleepingThread] = set()

    def wake_all(self) -> None:
        """Have all waiting threads check their conditions again. Any thread may call this."""
        for sleeper in list(self._sleepers):
            sleeper.wake()

    def wait_until(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Block until `condition` holds; False if it does not within `timeout_s`.

        The condition is checked again after each `wake_all`.
        """
        deadline = monotonic() + timeout_s
        sleeper = SleepingThread()
        self._sleepers.add(sleeper)
        try:
            while not condition():
                left = deadline - monotonic()
                if left <= 0:
                    return False
                self._wire_poller.wait(sleeper, int(min(left, LONGEST_S) * 1e9))
            return True
        finally:
            self._sleepers.discard(sleeper)
