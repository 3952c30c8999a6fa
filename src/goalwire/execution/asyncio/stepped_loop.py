"""An asyncio loop that never sleeps: an executor drives it step by step and sleeps in its stead.

All of asyncio works on it (tasks, timeouts, queues, threads, streams, subprocesses). It may be driven by
another thread with each step, and on a thread where another asyncio loop is running.

One step costs a few microseconds because it leans on names of asyncio that are private: `_run_once`,
`_make_self_pipe`, `_close_self_pipe`, `_write_to_self`, `_thread_id`, `_asyncgen_firstiter_hook`,
`_asyncgen_finalizer_hook`. They are used in this file alone, and GOALWIRE_STOCK_LOOP=1 does without.
"""

from __future__ import annotations

import asyncio
import os
import selectors
import sys
from asyncio.events import _get_running_loop, _set_running_loop
from asyncio.tasks import _enter_task, _leave_task
from heapq import heappop, heappush
from threading import get_ident
from typing import TYPE_CHECKING, Any

from goalwire.execution.asyncio.waiting import LoopWaker

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from contextvars import Context

    from goalwire.execution.fd_selector import FdSelector
    from goalwire.execution.monotonic import SteadyClock

STOCK = os.environ.get('GOALWIRE_STOCK_LOOP') == '1'
"""Whether to keep to asyncio's public names."""


class SteppedSelector(selectors.BaseSelector):
    """The loop's selector, which never waits: it reports what the executor's `FdSelector` saw."""

    def __init__(self, fd_selector: FdSelector, wake: Callable[[], None]) -> None:
        self._fd_selector = fd_selector
        self._wake = wake
        self._keys: dict[int, selectors.SelectorKey] = {}
        self.ready: dict[int, int] = {}
        """What the next `select` is to report."""
        self.reported: list[int] = []
        """Which descriptors the step at hand was told of."""

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        fd = fileobj if isinstance(fileobj, int) else fileobj.fileno()
        if fd in self._keys:
            raise KeyError(f'file descriptor {fd} is registered already')
        key = self._keys[fd] = selectors.SelectorKey(fileobj, fd, events, data)
        self._fd_selector.arm(fd, events, self._report)
        return key

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        fd = fileobj if isinstance(fileobj, int) else fileobj.fileno()
        key = self._keys.pop(fd)
        self.ready.pop(fd, None)
        self._fd_selector.disarm(fd)
        return key

    def modify(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        self.unregister(fileobj)
        return self.register(fileobj, events, data)

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:  # noqa: ARG002
        found = []
        while self.ready:
            fd, ready = self.ready.popitem()
            key = self._keys.get(fd)
            if key is not None:
                found.append((key, ready & key.events))
                self.reported.append(fd)
        return found

    def rearm(self) -> None:
        """After a step: watch again what was reported in it."""
        while self.reported:
            fd = self.reported.pop()
            key = self._keys.get(fd)
            if key is not None:
                self._fd_selector.disarm(fd)  # where it was registered anew in the step
                self._fd_selector.arm(fd, key.events, self._report)

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        return self._keys

    def get_key(self, fileobj: Any) -> selectors.SelectorKey:
        return self._keys[fileobj if isinstance(fileobj, int) else fileobj.fileno()]

    def close(self) -> None:
        for fd in self._keys:
            self._fd_selector.disarm(fd)
        self._keys.clear()

    def _report(self, fd: int, ready: int) -> None:
        self.ready[fd] = ready
        self._wake()


class SteppedLoop(asyncio.SelectorEventLoop):
    """See the module. `wake` asks the executor for a step, on any thread."""

    def __init__(self, fd_selector: FdSelector, clock: SteadyClock, wake: Callable[[], None]) -> None:
        self._lane_selector = SteppedSelector(fd_selector, wake)
        self._clock = clock
        self._wake = wake
        self._stepping = 0
        self.whens: list[float] = []
        """When callbacks are due that were put off, as a heap; some may have been cancelled since."""
        self.more = False
        """Whether callbacks wait for the next step."""
        self.goalwire_waker = LoopWaker(wake)
        super().__init__(self._lane_selector)

    def __del__(self) -> None:
        if not self.is_closed():
            self.close()

    def time(self) -> float:
        """The executor's steady time in s."""
        return self._clock.now() / 1e9

    def next_due(self) -> int:
        """When the earliest of `whens` is due, in steady ns."""
        when = self.whens[0]
        due = round(when * 1e9)
        return due if _is_due(when, due / 1e9) else due + 1000

    # Whatever is queued outside a step, by whichever thread, asks for one: so an Event that a plain callback
    # sets, or a Queue that it fills, wakes the coroutine that waits.

    def call_soon(  # type: ignore[override]
        self, callback: Callable[..., object], *args: Any, context: Context | None = None
    ) -> asyncio.Handle:
        handle = super().call_soon(callback, *args, context=context)
        self.more = True
        if self._stepping != get_ident():
            self._wake()
        return handle

    def call_soon_threadsafe(  # type: ignore[override]
        self, callback: Callable[..., object], *args: Any, context: Context | None = None
    ) -> asyncio.Handle:
        handle = super().call_soon_threadsafe(callback, *args, context=context)
        self.more = True
        self._wake()
        return handle

    def call_at(  # type: ignore[override]
        self, when: float, callback: Callable[..., object], *args: Any, context: Context | None = None
    ) -> asyncio.TimerHandle:
        handle = super().call_at(when, callback, *args, context=context)
        heappush(self.whens, when)
        if self._stepping != get_ident():
            self._wake()
        return handle

    def step(self, begin: Callable[[], None] | None = None) -> None:
        """Run what is ready now, once, and what `begin` makes ready before that.

        What a task raises as KeyboardInterrupt or SystemExit comes out.
        """
        outer = None if _get_running_loop() is None else _leave_outer()
        self._stepping = get_ident()
        try:
            if begin is not None:
                begin()
            if self.whens:
                self._forget_due()
            self._iterate()
        finally:
            self._stepping = 0
            if outer is not None:
                _return_to(*outer)
        if self._lane_selector.reported:
            self._lane_selector.rearm()

    def _forget_due(self) -> None:
        """Drop the times that the coming step will serve: those before its beginning."""
        whens, now = self.whens, self.time()
        while whens and _is_due(whens[0], now):
            heappop(whens)
            self.more = True

    def _iterate(self) -> None:
        waker = self.goalwire_waker
        if waker.calls or not waker.asleep:
            self.call_soon(waker.answer)
        self.call_soon(self.stop)
        self.more = False
        self.run_forever()
        # A reader's callback may queue more (signals do) without any public call that could be seen.
        self.more = self.more or bool(self._lane_selector.reported)


class FastSteppedLoop(SteppedLoop):
    """The same with asyncio's private names: without run_forever's preparations, and without a self-pipe."""

    _thread_id: int | None
    _csock: object

    def add_signal_handler(self, sig: int, callback: Callable[..., object], *args: Any) -> None:  # type: ignore[override]
        if self._csock is None:
            super()._make_self_pipe()  # type: ignore[misc]
        super().add_signal_handler(sig, callback, *args)

    def _make_self_pipe(self) -> None:
        self._ssock = self._csock = None

    def _close_self_pipe(self) -> None:
        if self._csock is not None:
            super()._close_self_pipe()  # type: ignore[misc]

    def _write_to_self(self) -> None:
        self.more = True
        self._wake()

    def _iterate(self) -> None:
        hooks = sys.get_asyncgen_hooks()
        sys.set_asyncgen_hooks(self._asyncgen_firstiter_hook, self._asyncgen_finalizer_hook)  # type: ignore[attr-defined]
        self._thread_id = self._stepping
        _set_running_loop(self)
        try:
            waker = self.goalwire_waker
            if waker.calls or not waker.asleep:
                waker.answer()
            if self.more or self._lane_selector.ready:  # an answer alone needs no turn of the loop
                self.more = False
                self._run_once()  # type: ignore[attr-defined]
        finally:
            _set_running_loop(None)
            self._thread_id = None
            sys.set_asyncgen_hooks(*hooks)


def _is_due(when: float, now: float) -> bool:
    """Whether a loop, which rounds its times to nanoseconds at best, holds `when` to be due at `now`."""
    return when < now + 1e-9


def new_loop(fd_selector: FdSelector, clock: SteadyClock, wake: Callable[[], None]) -> SteppedLoop:
    """A loop for one runner."""
    return (SteppedLoop if STOCK else FastSteppedLoop)(fd_selector, clock, wake)


def _leave_outer() -> tuple[asyncio.AbstractEventLoop, asyncio.Task[Any] | None] | None:
    """Where an asyncio loop runs on this thread already, step out of it and of its current task."""
    loop = _get_running_loop()
    if loop is None:
        return None
    task = asyncio.current_task(loop)
    if task is not None:
        _leave_task(loop, task)
    _set_running_loop(None)
    return loop, task


def _return_to(loop: asyncio.AbstractEventLoop, task: asyncio.Task[Any] | None) -> None:
    _set_running_loop(loop)
    if task is not None:
        _enter_task(loop, task)
