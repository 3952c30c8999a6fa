"""An asyncio loop that never sleeps. The executor runs it step by step, and sleeps between the steps.

All of asyncio works on it (tasks, timeouts, queues, threads, streams, subprocesses). Each step may run on
another thread, also on one where another asyncio loop is running.

It uses asyncio's public names only, except in one case: another asyncio loop may already run on the thread (a
notebook, `rclpy.spin` in a coroutine). That loop is left while a step lasts, and Python has no public way to
do so. The four names for it are in asyncio's `__all__`, meant for authors of loops. With
GOALWIRE_STOCK_LOOP=1 they are not used, and such a step is refused: docs/adr/015-asyncio-within.md.
"""

from __future__ import annotations

import asyncio
import os
import selectors
from contextlib import suppress
from heapq import heappop, heappush
from threading import get_ident
from typing import TYPE_CHECKING, Any

from goalwire.execution.asyncio.loop_waker import LoopWaker
from goalwire.execution.waiters import running_loop

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from contextvars import Context

    from goalwire.execution.asyncio.fd_selector import FdSelector
    from goalwire.execution.time.steady_clock import SteadyClock

_get_running_loop: Callable[[], asyncio.AbstractEventLoop | None]
_get_running_loop = getattr(asyncio, '_get_running_loop', running_loop)
_set_running_loop: Any = getattr(asyncio, '_set_running_loop', None)
_enter_task: Any = getattr(asyncio, '_enter_task', None)
_leave_task: Any = getattr(asyncio, '_leave_task', None)
NESTS = (
    bool(_set_running_loop and _enter_task and _leave_task) and os.environ.get('GOALWIRE_STOCK_LOOP') != '1'
)
"""True if a step may run on a thread on which another asyncio loop is running."""


class SteppedSelector(selectors.BaseSelector):
    """The loop's selector, which never waits: it reports what the executor's `FdSelector` saw."""

    def __init__(self, fd_selector: FdSelector, wake: Callable[[], None]) -> None:
        self._fd_selector = fd_selector
        self._wake = wake
        self._keys: dict[int, selectors.SelectorKey] = {}
        self.ready: dict[int, int] = {}
        """The ready descriptors that the next `select` reports."""
        self.reported: list[int] = []
        """The descriptors that `select` has reported in the present step."""
        self.opening = True
        """True while the loop is constructed. It registers its own pipe then, which is not watched yet."""
        self._unwatched: list[int] = []

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        fd = fileobj if isinstance(fileobj, int) else fileobj.fileno()
        if fd in self._keys:
            raise KeyError(f'file descriptor {fd} is registered already')
        key = self._keys[fd] = selectors.SelectorKey(fileobj, fd, events, data)
        if self.opening:
            self._unwatched.append(fd)
        else:
            self._fd_selector.arm(fd, events, self._report)
        return key

    def watch_own_pipe(self) -> None:
        """Watch the loop's own pipe, into which Python writes signals, after emptying it.

        Threads that queue a callback write into it, too, and a full pipe would have no room for a signal.
        """
        while self._unwatched:
            fd = self._unwatched.pop()
            if fd in self._keys:
                with suppress(OSError):  # raised when the pipe is empty
                    while os.read(fd, 4096):
                        pass
                self._fd_selector.arm(fd, self._keys[fd].events, self._report)

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
        """After a step, watch again the descriptors that were reported in it."""
        while self.reported:
            fd = self.reported.pop()
            key = self._keys.get(fd)
            if key is not None:
                self._fd_selector.disarm(fd)  # a callback may have armed the descriptor anew
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
    """An asyncio loop that the executor steps. Any thread calls `wake` to ask the executor for a step."""

    def __init__(self, fd_selector: FdSelector, clock: SteadyClock, wake: Callable[[], None]) -> None:
        self._stepped_selector = SteppedSelector(fd_selector, wake)
        self._clock = clock
        self._wake = wake
        self._stepping = 0
        self.whens: list[float] = []
        """A heap of the due times of `call_at`. It may hold times of calls that were cancelled since."""
        self.more = False
        """True if callbacks wait for the next step."""
        self.goalwire_waker = LoopWaker(wake)
        super().__init__(self._stepped_selector)
        self._stepped_selector.opening = False

    def __del__(self) -> None:
        if not self.is_closed():
            self.close()

    def time(self) -> float:
        """The executor's steady time in s."""
        return self._clock.now() / 1e9

    def next_due(self) -> int:
        """Return the earliest due time of `whens`, in steady ns."""
        when = self.whens[0]
        due = round(when * 1e9)
        return due if _is_due(when, due / 1e9) else due + 1000

    # A callback that is queued outside a step asks for a step, on any thread. So a plain callback that sets
    # an asyncio.Event, or fills a Queue, wakes the coroutine that waits for it.

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

    def add_signal_handler(self, sig: int, callback: Callable[..., object], *args: Any) -> None:  # type: ignore[override]
        self._stepped_selector.watch_own_pipe()
        super().add_signal_handler(sig, callback, *args)

    def step(self, begin: Callable[[], None] | None = None) -> None:
        """Run the callbacks that are ready now, once, including those that `begin` makes ready.

        Raises the KeyboardInterrupt or SystemExit of a task.
        """
        # While `_stepping` has this thread's ident, callbacks that the step itself queues call no `wake`: the
        # caller looks at `more` and `whens` after the step. Other threads' callbacks still call `wake`.
        outer = _leave_outer() if _get_running_loop() is not None else None
        self._stepping = get_ident()
        try:
            if begin is not None:
                begin()
            if self.whens:
                self._discard_due()
            waker = self.goalwire_waker
            if waker.calls or not waker.asleep:
                super().call_soon(waker.run_pending)
            self.more = False
            self.stop()  # makes `run_forever` run the ready callbacks once, without waiting
            self.run_forever()
        finally:
            self._stepping = 0
            if outer is not None:
                _return_to(*outer)
        if self._stepped_selector.reported:
            # A descriptor's callback may have queued more callbacks without `call_soon`, as asyncio does for
            # signals.
            self.more = True
            self._stepped_selector.rearm()

    def _discard_due(self) -> None:
        """Discard the times that are due, since this step runs their callbacks."""
        whens, now = self.whens, self.time()
        while whens and _is_due(whens[0], now):
            heappop(whens)


def _is_due(when: float, now: float) -> bool:
    """Tell whether asyncio treats `when` as due at `now`: asyncio allows one tick of its clock, here 1 ns."""
    return when < now + 1e-9


def _leave_outer() -> tuple[asyncio.AbstractEventLoop, asyncio.Task[Any] | None]:
    """Hide the asyncio loop that runs on this thread, and its current task, until `_return_to`."""
    if not NESTS:
        raise RuntimeError(
            'a coroutine callback cannot go on here: an asyncio loop runs on this thread, and Python has no '
            'public way to run another one in it. Spin in a thread of its own, or unset GOALWIRE_STOCK_LOOP'
        )
    loop = asyncio.get_running_loop()
    task = asyncio.current_task(loop)
    if task is not None:
        _leave_task(loop, task)
    _set_running_loop(None)
    return loop, task


def _return_to(loop: asyncio.AbstractEventLoop, task: asyncio.Task[Any] | None) -> None:
    _set_running_loop(loop)
    if task is not None:
        _enter_task(loop, task)
