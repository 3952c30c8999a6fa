"""Runs coroutine callbacks as asyncio tasks, on any free thread of the executor."""

from __future__ import annotations

import asyncio
from _thread import allocate_lock
from collections import deque
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

from goalwire.concurrency.exits import Stage, at_exit, perform
from goalwire.concurrency.forks import leak
from goalwire.execution.asyncio.stepped_loop import SteppedLoop
from goalwire.execution.ready_queue import CallbackSource
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine
    from contextvars import Context

    from goalwire.execution.asyncio.fd_selector import FdSelector
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.execution.time.steady_clock import SteadyClock


class Start(NamedTuple):
    """A coroutine callback to be run, and the function `ended`, which is called when it has ended."""

    coroutine: Coroutine[Any, Any, object]
    context: Context
    ended: Callable[[], None]


MOST_RUNNERS = 256
"""The largest number of shared runners. If all are in use, further coroutines share a runner with others."""


class CoroutineRunner(CallbackSource):
    """An asyncio loop that is bound to no thread. The executor runs it as ready work, one step a turn.

    One thread at a time runs a step. A second thread that comes meanwhile sets `_missed` and goes on with
    other work; the first thread then asks for one more step. `fail` gets what the coroutines raise.
    """

    __slots__ = (
        '_closing',
        '_fail',
        '_missed',
        '_posted',
        '_starting',
        '_tasks',
        '_timer_entry',
        '_turn',
        'loop',
    )

    def __init__(
        self,
        work_queue: NodeWorkQueue,
        fd_selector: FdSelector,
        clock: SteadyClock,
        fail: Callable[[BaseException], None],
    ) -> None:
        super().__init__(work_queue, None)
        self._fail = fail
        self._posted = self._missed = self._closing = False
        self._turn = allocate_lock()
        self._tasks: dict[int, asyncio.Task[Any]] = {}
        """The tasks by the id of their coroutines. asyncio itself holds tasks only weakly."""
        self._starting: deque[Start] = deque()
        self._timer_entry = TimerEntry(self.wake)
        self.loop = SteppedLoop(fd_selector, clock, self.wake)

    @property
    def driven(self) -> bool:
        """True if a thread is in the middle of a step."""
        return self._turn.locked()

    @property
    def load(self) -> int:
        """The number of callbacks that this runner has started and that have not ended."""
        return len(self._tasks) + len(self._starting)

    def start(self, start: Start) -> None:
        """Have the next step make an asyncio task of a coroutine. Callable from any thread."""
        self._starting.append(start)

    def wake(self) -> None:
        """Ask for a step. Callable from any thread."""
        if not self._posted:
            self._posted = True
            try:
                self.work_queue.post(self)
            except BaseException:  # a signal handler has raised, perhaps before the post: post again
                self.work_queue.post(self)
                raise

    def run(self) -> None:
        """Do one step, and ask for the next one if there is more to do."""
        # `_posted` is reset first, so a `wake` during the step posts the runner again. `_missed` is set
        # before `_turn` is looked at again: so either the other thread sees `_missed` after its step, or
        # `_turn` is free.
        self._posted = False
        if not self._turn.acquire(blocking=False):
            self._missed = True
            if not self._turn.locked():
                self.wake()
            return
        self._missed = False
        due = None
        is_whole = False
        try:
            if not self._closing:
                loop = self.loop
                loop.step(self._begin if self._starting else None)
                if loop.whens:
                    due = loop.next_due()
            is_whole = True
        finally:
            self._turn.release()
            if self._closing:
                self.close()
            elif not is_whole:  # Ctrl-C or sys.exit() ended the step: its other calls run later
                self.loop.more = True
                self.wake()
        if self._closing:
            return
        if self._missed or self.loop.more or self._starting:
            self.wake()
        elif due is not None:
            before = self._timer_entry.due  # read once, since another thread may change `due`
            if before is None or due < before:
                self.work_queue.set_timer_entry(self._timer_entry, due)

    def close(self) -> None:
        """Cancel the coroutines of this runner and close the loop.

        If a thread is in the middle of a step, that thread closes the loop after the step.
        """
        # `_closing` is set before `_turn` is tried, and `run` reads `_closing` after the release of `_turn`:
        # so one of the two closes the loop.
        self._closing = True
        self.work_queue.discard_timer_entry(self._timer_entry)
        if self._turn.acquire(blocking=False):
            try:
                self._close_loop()
            finally:
                self._turn.release()

    def _begin(self) -> None:
        while self._starting:
            start = self._starting.popleft()
            task = self.loop.create_task(self._run_coroutine(start), context=start.context)
            self._tasks[id(start.coroutine)] = task

    async def _run_coroutine(self, start: Start) -> None:
        try:
            await start.coroutine
        except (asyncio.CancelledError, GeneratorExit):
            raise
        except BaseException as error:  # spin raises the error
            self._fail(error)
        finally:
            del self._tasks[id(start.coroutine)]
            start.ended()

    def _close_loop(self) -> None:
        """Cancel all tasks, step the loop until they have ended, at most ten times, and close the loop."""
        loop = self.loop
        if loop.is_closed():
            return
        if self._tasks or self._starting:
            loop.step(self._begin)  # begin all coroutines: only those that have begun can clean up
        left = asyncio.all_tasks(loop)
        for task in left:
            task.cancel()
        for _ in range(10):
            if not left:
                break
            loop.step()
            left = {task for task in left if not task.done()}
        loop.close()


class RunnerPool:
    """The runners of one executor.

    Without `spread` all coroutines share one runner, since one thread runs all of them. With `spread` each
    exclusive group has its own runner, and each callback of another group has its own runner while it runs.
    So a coroutine that blocks holds up only the callbacks of its group.
    """

    def __init__(self, make: Callable[[], CoroutineRunner], *, spread: bool) -> None:
        self._make = make
        self._spread = spread
        self._lock = Lock()
        self._closed = False
        self._shared: list[CoroutineRunner] = []
        self._of_group: WeakKeyDictionary[CallbackGroup, CoroutineRunner] = WeakKeyDictionary()
        _open.add(self)

    def start(
        self,
        coroutine: Coroutine[Any, Any, object],
        context: Context,
        ended: Callable[[], None],
        group: CallbackGroup | None,
    ) -> None:
        """Start a coroutine in the runner for `group`, and run it up to its first await.

        `ended` is called when the coroutine has ended. After `close` the coroutine is cancelled at its first
        await.
        """
        # The runner is chosen and loaded under the lock. So two coroutines do not choose the same idle
        # runner, and `close` finds every runner that was loaded before it.
        with self._lock:
            runner = self._make() if self._closed else self._runner_for(group)
            runner.start(Start(coroutine, context, ended))
        if self._closed:
            runner.close()
        else:
            runner.run()

    def close(self) -> None:
        """Cancel all coroutines, also those that are started later, and close all runners."""
        self._closed = True
        with self._lock:
            runners = [*self._shared, *self._of_group.values()]
        for runner in runners:
            runner.close()

    def reset_in_child(self) -> None:
        """In a forked child, forget the coroutines: the parent cleans them up.

        The references are kept: Python runs the `finally` blocks of a coroutine without references.
        """
        self._lock = Lock()
        for runner in [*self._shared, *self._of_group.values()]:
            leak(runner)
        self._shared = []
        self._of_group = WeakKeyDictionary()

    def _runner_for(self, group: CallbackGroup | None) -> CoroutineRunner:
        if self._spread and group is not None and group.exclusive:
            runner = self._of_group.get(group)
            if runner is None:
                runner = self._of_group[group] = self._make()
            if not runner.driven:
                return runner
        return self._idle_runner()

    def _idle_runner(self) -> CoroutineRunner:
        """Return a shared runner that no thread is stepping: a nested spin cannot step the runner that called
        it.
        """
        for runner in self._shared:
            if not runner.driven and (not self._spread or runner.load == 0):
                return runner
        if len(self._shared) < MOST_RUNNERS:
            runner = self._make()
            self._shared.append(runner)
            return runner
        return min(self._shared, key=lambda runner: runner.load)


_open: WeakMembers[RunnerPool] = WeakMembers()


def _close_all() -> None:
    """At the interpreter's exit, let the coroutines of executors that were not shut down clean up."""
    perform([runners.close for runners in _open.alive()])


at_exit(Stage.THREADS, _close_all)
