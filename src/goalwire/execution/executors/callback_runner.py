"""Runs callbacks, plain ones and coroutines, as their groups allow. All executors share it."""

from __future__ import annotations

from _thread import allocate_lock
from collections import deque
from collections.abc import Coroutine
from contextvars import copy_context
from functools import partial
from types import CoroutineType
from typing import TYPE_CHECKING, Any

from goalwire.concurrency.forks import reset_in_children
from goalwire.concurrency.snapshots import copy_of
from goalwire.execution.current_callback import held_groups
from goalwire.execution.executors.callback_chooser import CallbackChooser

if TYPE_CHECKING:
    from goalwire.execution.asyncio.coroutine_runner import CoroutineRunner, RunnerPool
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.ready_queue import CallbackSource
    from goalwire.execution.shutdown_signal import ShutdownSignal
    from goalwire.execution.waiters import StopCondition, WireWaiter


class CallbackRunner(CallbackChooser):
    """Runs callbacks on the calling thread. The executor decides which threads call."""

    _spread_runners = False
    has_spun = False
    """True if a thread has ever run callbacks with this runner."""

    def __init__(self, shutdown_signal: ShutdownSignal) -> None:
        super().__init__(shutdown_signal)
        self._failures: deque[BaseException] = deque()
        self._refused: deque[CallbackSource] = deque()
        self._asking: object = object()
        """A mark that each end of a callback replaces. It is not a counter, because two threads that
        increment at once may lose an increment.
        """
        self._runners: RunnerPool | None = None
        self._runners_lock = allocate_lock()
        reset_in_children(self)

    def reset_in_child(self) -> None:
        """In a forked child, forget the threads and the coroutines of the parent."""
        self._runners_lock = allocate_lock()
        super().reset_in_child()
        if self._runners is not None:
            self._runners.reset_in_child()

    def _run_callbacks(
        self, waiter: WireWaiter, stop: StopCondition, deadline: int | None, *, once: bool
    ) -> None:
        """Run callbacks until `stop` comes or `deadline` has passed; with `once` only one callback."""
        if self._failures:
            self._raise_failure()
        while True:
            source = self._take(waiter, stop, deadline)
            if source is None:
                return
            performed = self._perform(source)
            if self._failures:
                self._raise_failure()
            if (performed and once) or not self._shutdown_signal.alive or stop.completion_state:
                return
            if deadline is not None and not once and self._is_past(deadline):
                return  # without this look, callbacks that are always due would keep the spin from ending

    def _work_off(self, deadline: int | None) -> None:
        """Run the callbacks of all events that wait now, in order, and then those of the events that came
        meanwhile.

        rclpy handles a response after the tasks and messages that came with it, such as the execution of an
        accepted goal and its feedback. Events that come after these two rounds are left to later spins.
        """
        self._work_off_once(deadline)
        if self._ready.items:
            self._work_off_once(deadline)

    def _work_off_once(self, deadline: int | None) -> None:
        waiting = [(source, source.backlog) for source in copy_of(self._ready.items)]
        while waiting:
            left = []
            for source, events in waiting:
                if self._is_shutdown or not self._shutdown_signal.alive or self._is_past(deadline):
                    return
                if self._ready.take(source):  # False if another thread has taken the source
                    self._perform(source)
                    self._raise_failure()
                    if events > 1:
                        left.append((source, events - 1))
            waiting = left

    def _perform(self, source: CallbackSource) -> bool:
        """Run one callback of `source`; False if its group is busy or its node has left the executor.

        hot path: `held_groups` is not reset after the callback, since the next one is mostly of the same
        group, and setting it twice takes 2 us after a sleep. The caller restores the earlier value.
        """
        if source.work_queue.queue is not self._ready:
            source.work_queue.post(source)
            return False
        group = source.group
        if group is not None:
            if group.foreign:
                if not self._may_begin(source, group):
                    return False
            elif not group.begin(source):
                group.park(source)
                return False
        held = held_groups.get()
        if group is None or not group.exclusive:
            if held:
                held_groups.set(())
        elif not held or held[0] is not group:
            held_groups.set((group,))
        try:
            outcome = source.run()
            if outcome is not None and (type(outcome) is CoroutineType or isinstance(outcome, Coroutine)):
                self._start(outcome, source, group)
                return True
        except BaseException:
            self._end(source, group)
            raise
        self._end(source, group)
        return True

    PERFORM = _perform.__code__
    """The code object that calls every callback: it marks the frames of callbacks in a stack."""

    def _end(self, source: CallbackSource, group: CallbackGroup | None) -> None:
        """Note that a callback has ended."""
        if group is not None:
            group.ended(source)
            if group.foreign:
                self._asking = object()
        source.settle()
        if self._refused:
            self._ask_again()

    def _may_begin(self, source: CallbackSource, group: CallbackGroup) -> bool:
        """Ask a group whose rule a program has written, and keep the work that it refuses.

        `_end` changes `_asking`, then looks for kept work. `_may_begin` keeps the work, then looks at
        `_asking`. So if a callback ends meanwhile, one of the two posts the work again.
        """
        asking = self._asking
        if group.begin(source):
            return True
        self._refused.append(source)
        if self._asking is not asking:
            self._ask_again()
        return False

    def _ask_again(self) -> None:
        """Post the refused work again. As in rclpy, a program's own groups are asked after each callback."""
        for _ in range(len(self._refused)):
            try:
                source = self._refused.popleft()
            except IndexError:
                return
            source.work_queue.post(source)

    def _start(
        self, coroutine: Coroutine[Any, Any, object], source: CallbackSource, group: CallbackGroup | None
    ) -> None:
        """Run a coroutine callback up to its first await, at once: so it starts in order with plain
        callbacks.
        """
        runners = self._runners or self._open_runners()
        runners.start(coroutine, copy_context(), partial(self._end, source, group), group)

    def _raise_failure(self) -> None:
        """Raise the error of a coroutine callback, or of a callback on another thread."""
        if self._failures:
            raise self._failures.popleft()

    def _fail(self, error: BaseException) -> None:
        self._failures.append(error)

    def _open_runners(self) -> RunnerPool:
        from goalwire.execution.asyncio.coroutine_runner import RunnerPool

        with self._runners_lock:
            if self._runners is None:
                self._runners = RunnerPool(self._make_runner, spread=self._spread_runners)
        if self._is_shutdown:
            self._runners.close()
        return self._runners

    def _make_runner(self) -> CoroutineRunner:
        from goalwire.execution.asyncio.coroutine_runner import CoroutineRunner

        return CoroutineRunner(self.work_queue, self._fd_selector, self._clock, self._fail)

    def _close_runners(self) -> None:
        if self._runners is not None:
            self._runners.close()
        self._fd_selector.close()
