"""Runs something in the midst of something else, on the same thread, as a signal's handler does.

Python runs a handler where a function begins, after a call of C, and where a loop goes on. Here it comes
before each line that the code under test runs, or at each of the first two, once for each of them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from types import FrameType
from typing import Any, TypeAlias

import goalwire

_SOURCE = str(Path(goalwire.__file__).parent)
_Trace: TypeAlias = Callable[[FrameType, str, Any], Any]


class Interruption:
    """Runs a handler at the `number`th place in goalwire's code that `run` comes to."""

    def __init__(self, number: int, events: frozenset[str]) -> None:
        self._left = number
        self._events = events
        self._handler: Callable[[], object] | None = None
        self.place = ''
        """Where it was: file and line. Empty where `run` ended before."""

    def run(self, action: Callable[[], object], handler: Callable[[], object]) -> None:
        """Do `action`, interrupted by `handler`."""
        self._handler = handler
        before = sys.gettrace(), sys.getprofile()
        if 'line' in self._events:
            sys.settrace(self._trace)
        else:
            sys.setprofile(self._trace)
        try:
            action()
        finally:
            sys.settrace(before[0])
            sys.setprofile(before[1])

    def _trace(self, frame: FrameType, event: str, _argument: Any) -> _Trace | None:
        if self._handler is None or not frame.f_code.co_filename.startswith(_SOURCE):
            return None
        if event in self._events:
            self._left -= 1
            if self._left < 0:
                handler, self._handler = self._handler, None
                sys.settrace(None)
                sys.setprofile(None)
                self.place = f'{Path(frame.f_code.co_filename).name}:{frame.f_lineno}'
                handler()
        return self._trace


def at_each_line() -> Iterator[Interruption]:
    """Yield an interruption before each line there is, until one was not needed any more."""
    return _at_each(frozenset({'line'}))


def at_each_call() -> Iterator[Interruption]:
    """Yield an interruption where each function of Python's begins, and where each of C's has ended.

    As with `at_each_line`, they end with one that was not needed any more.
    """
    return _at_each(frozenset({'call', 'c_return'}))


def _at_each(events: frozenset[str]) -> Iterator[Interruption]:
    for number in count():
        interruption = Interruption(number, events)
        yield interruption
        if not interruption.place:
            assert number > 1, 'nothing was seen'
            return
