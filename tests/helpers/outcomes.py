"""How calls and goals ended, counted by kind."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from helpers.held_up import HeldUp

from goalwire.errors import GoalwireError

DONE = 'done'
"""The kind of a call or goal that ended as it should."""


class Outcomes:
    """Counts 'done' and the names of errors. An error that is not one of goalwire's goes on."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.slowest: float | None = None
        """The longest time from a fault to its typed error, in s."""
        self._held_up = HeldUp()

    @contextmanager
    def counted(self, since: Callable[[], int] | None = None) -> Iterator[None]:
        """Count how the block ends, an error with the time that it took.

        That is the time since the fault struck where `since` tells it (steady ns), else since the beginning.
        """
        began = time.monotonic_ns()
        try:
            yield
        except GoalwireError as error:
            struck = began if since is None else since()
            self.note(type(error).__name__, (time.monotonic_ns() - struck) / 1e9)
        else:
            self.note(DONE)

    def note(self, kind: str, took: float | None = None, number: int = 1) -> None:
        """Count endings of a kind; for an error, `took` is the time since the fault, in s."""
        self.counts[kind] += number
        if took is not None:
            self.slowest = max(took, self.slowest or 0.0)

    def expect_within(self, seconds: float, held_up: HeldUp | None = None) -> None:
        """Insist that each error came within `seconds`, the time aside in which the machine had no core free.

        `held_up` measures that time if another process than this one was to be told.
        """
        assert self.slowest is not None
        assert self.slowest < seconds + (held_up or self._held_up).seconds

    @property
    def total(self) -> int:
        """How many have ended."""
        return self.counts.total()
