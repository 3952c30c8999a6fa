"""An engine that a running asyncio loop drives: the loop takes the place of a thread that spins."""

from __future__ import annotations

import asyncio
from contextvars import copy_context
from functools import partial
from typing import TYPE_CHECKING, Any

from goalwire.execution.asyncio_waiting import delay_s
from goalwire.execution.current import active_executors
from goalwire.execution.engine import Engine
from goalwire.execution.loop_waker import shared_waker

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from goalwire.execution.asyncio_callback_tasks import CallbackTasks
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.callback_source import CallbackSource
    from goalwire.execution.node_work_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal


class AsyncExecutor(Engine):
    """Runs what `work_queue` is posted, on the loop's thread: plain callbacks in line, coroutines as tasks.

    Whoever posts while nothing is under way asks the loop for a turn, with one wake-up for a whole burst; the
    turn runs what is there by then, and the loop's other callbacks have theirs in between. A callback that
    raises ends this: the error is raised by `tasks`, which cancels what runs in them.
    """

    def __init__(
        self,
        work_queue: NodeWorkQueue,
        shutdown_signal: ShutdownSignal,
        tasks: asyncio.TaskGroup,
        runs: CallbackTasks,
        ended: Callable[[], None],
    ) -> None:
        """`ended` is called, on the loop's thread, when the shutdown begins."""
        super().__init__(shutdown_signal)
        self._node_home = work_queue
        self._tasks = tasks
        self._runs = runs
        self._ended = ended
        self._loop = asyncio.get_running_loop()
        self._waker = shared_waker(self._loop)
        self._context = copy_context()
        # Not call_soon, even on the loop's own thread: a signal handler may run while the loop sleeps.
        self._ask = partial(self._waker.call, partial(self._context.run, self._turn))
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due: int | None = None  # None: there is no timer
        self._watch = shutdown_signal.watch(self._ask)

    def open(self) -> None:
        """Begin. From now on a call that blocks the loop's thread, on something of this node, is refused."""
        active_executors.executors.append(self)
        self._waker.open()
        self._shutdown_signal.add_external_sleeper(self)
        self._node_home.attach(self._ready, self._timer_heap)
        self._listen()

    def close(self) -> None:
        """Run no more callbacks; what waits goes back to the node. Idempotent; the loop's thread alone."""
        if self._is_shutdown:
            return
        self._is_shutdown = True
        self._watch.close()
        self._ready.unlisten(self._ask)
        self._set_timer(None)
        active_executors.executors.remove(self)
        self._shutdown_signal.remove_external_sleeper(self)
        self._node_home.detach()
        self._close_runners()
        self._waker.close()

    def thread_waits_alone(self) -> bool:
        """True: nothing runs here while the loop's thread blocks."""
        return True

    def add_capacity(self, count: int) -> None:
        """There is no other thread that could make up for it."""

    def _turn(self) -> None:
        if self._is_shutdown:
            return
        self._ready.unlisten(self._ask)
        if not self._shutdown_signal.alive:
            self._ended()
            return
        try:
            self._run_what_is_there()
        except (KeyboardInterrupt, SystemExit):
            self.close()
            raise
        except BaseException as error:
            self.close()
            self._tasks.create_task(_raise(error))
            return
        self._listen()

    def _run_what_is_there(self) -> None:
        for _ in range(len(self._ready.items) + 1):  # one more for an alarm
            source = self._next()
            if source is None:
                return
            self._perform(source)
            if not self._shutdown_signal.alive:
                return

    def _listen(self) -> None:
        """Be asked when there is work, then look at the alarms: one that was set in between asks, too."""
        self._ready.listen(self._ask)
        due = self._timer_heap.earliest
        if due != self._timer_due:
            self._set_timer(due)

    def _set_timer(self, due: int | None) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._timer_due = due
        if due is not None:
            delay = delay_s(due - self._clock.now())
            self._timer = self._loop.call_later(delay, self._ring, context=self._context)

    def _ring(self) -> None:
        self._timer = self._timer_due = None
        self._turn()

    def _start(
        self, coroutine: Coroutine[Any, Any, object], source: CallbackSource, group: CallbackGroup | None
    ) -> None:
        task = self._tasks.create_task(coroutine)
        self._runs.add(task, source)

        def over(task: asyncio.Task[Any]) -> None:
            self._runs.discard(task)
            if not task.cancelled() and task.exception() is not None:
                self.close()
            self._end(source, group)

        task.add_done_callback(over)


async def _raise(error: BaseException) -> None:
    raise error
