"""Copies of a deque that another thread changes."""

from __future__ import annotations

import threading
from collections import deque

from goalwire.concurrency.snapshots import copy_of


def test_a_copy_beside_a_thread_that_appends_and_takes_is_whole() -> None:
    """Without the GIL `deque.copy` raises RuntimeError here; each copy has what lies between the two ends."""
    items = deque(range(100))

    def turn() -> None:
        for number in range(100, 20_000):
            items.append(number)
            items.popleft()

    thread = threading.Thread(target=turn)
    thread.start()
    while thread.is_alive():
        copied = list(copy_of(items))
        assert copied == list(range(copied[0], copied[0] + len(copied)))
    thread.join()
    assert copy_of(items) == items


class Restless(deque[int]):
    """Raises as a deque does that another thread has changed, the first two times."""

    fails = 2

    def copy(self) -> Restless:
        if self.fails:
            self.fails -= 1
            raise RuntimeError('deque mutated during iteration')
        return self


def test_a_copy_that_was_disturbed_is_made_again() -> None:
    items = Restless([1, 2])
    assert list(copy_of(items)) == [1, 2]
    assert items.fails == 0
