"""The executor of the asyncio API: the running asyncio loop takes the place of a spinning thread."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from contextvars import copy_context
from functools import partial
from typing import TYPE_CHECKING, Any, Self

from goalwire.execution.asyncio.loop_waker import shared_waker
from goalwire.execution.asyncio.loop_watch import BusyLoop
from goalwire.execution.asyncio.waiting import delay_s
from goalwire.execution.asyncio.wire_reader import read_wire
from goalwire.execution.current_callback import active_executors
from goalwire.execution.executors.callback_runner import CallbackRunner
from goalwire.execution.executors.spin_watch import SpinWatch

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine
    from types import TracebackType

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal


class CallbackTasks:
    """The tasks that run coroutine callbacks, with their sources. Only the loop's thread uses this class."""

    def __init__(self) -> None:
        self._tasks: dict[asyncio.Task[Any], CallbackSource] = {}

    def __len__(self) -> int:
        return len(self._tasks)

    def add(self, task: asyncio.Task[Any], source: CallbackSource) -> None:
        """Note that `task` runs a callback of `source`."""
        self._tasks[task] = source

    def discard(self, task: asyncio.Task[Any]) -> None:
        """Remove a task that has ended."""
        self._tasks.pop(task, None)

    def cancel(self, source: CallbackSource) -> None:
        """Cancel the callbacks of `source`, except the callback that calls this: it may go on to its end."""
        self._cancel([task for task, its_work in self._tasks.items() if its_work is source])

    def cancel_all(self) -> None:
        """Cancel every callback, except the callback that calls this."""
        self._cancel(list(self._tasks))

    def _cancel(self, tasks: list[asyncio.Task[Any]]) -> None:
        if not tasks:
            return
        calling = asyncio.current_task()
        for task in tasks:
            if task is not calling:
                task.cancel()


class AsyncExecutor(CallbackRunner):
    """Runs the work posted to `work_queue`: plain callbacks on the loop's thread, coroutines as tasks.

    The first post asks the loop for a turn; the posts before that turn need no further wake-up. The turn runs
    the work that is there by then, and the loop runs its other callbacks between the turns. An error of a
    callback ends this executor: the task group `tasks` raises it, and cancels the other callbacks.
    """

    def __init__(
        self,
        work_queue: NodeWorkQueue,
        shutdown_signal: ShutdownSignal,
        tasks: asyncio.TaskGroup,
        runs: CallbackTasks,
        ended: Callable[[], None],
    ) -> None:
        """Make an executor for the running loop. `ended` is called on the loop's thread at the shutdown."""
        super().__init__(shutdown_signal)
        self._node_work_queue = work_queue
        self._tasks = tasks
        self._runs = runs
        self._ended = ended
        self._loop = asyncio.get_running_loop()
        self._waker = shared_waker(self._loop)
        self._context = copy_context()
        # Not call_soon, even on the loop's own thread: a signal handler may run while the loop sleeps.
        self._ask = partial(self._waker.call, partial(self._context.run, self._turn))
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due: int | None = None  # None: the loop has no timer set
        self._stop_reading: Callable[[], None] | None = None
        """Stops the reading of the wire by this loop; None if the loop does not read it."""
        self._on_this_thread = active_executors.executors
        self._watch = shutdown_signal.watch(self._on_shutdown)
        self._spin_watch: SpinWatch | None = None

    def open(self) -> None:
        """Begin to run callbacks. From now on, calls that would block the loop's thread to wait for this node
        raise an error.
        """
        self._on_this_thread.append(self)
        self._waker.open()
        self._stop_reading = read_wire(self._loop, self._shutdown_signal.wire_poller)
        if self._stop_reading is None:
            self._shutdown_signal.add_external_sleeper(self)
        self._node_work_queue.attach(self._ready, self._timer_heap)
        self._listen()
        busy = BusyLoop(self._waker, self._ready, self._timer_heap)
        self._spin_watch = SpinWatch(self._shutdown_signal, busy.find)

    def close(self) -> None:
        """Stop running callbacks, and give the waiting work back to the node.

        Idempotent; only on the loop's thread.
        """
        if self._is_shutdown:
            return
        self._is_shutdown = True
        self._watch.close()
        if self._spin_watch is not None:
            self._spin_watch.close()
        self._ready.unlisten(self._ask)
        self._set_timer(None)
        self._stop_counting_as_active()
        if self._stop_reading is not None:
            self._stop_reading()
        else:
            self._shutdown_signal.remove_external_sleeper(self)
        self._node_work_queue.detach()
        self._close_runners()
        self._waker.close()

    def thread_waits_alone(self) -> bool:
        """Return True: this executor runs no callback while the loop's thread blocks."""
        return True

    def add_capacity(self, count: int) -> None:
        """Do nothing, since only the loop's thread runs callbacks."""

    def _on_shutdown(self) -> None:
        """Ask the loop for the turn that ends this executor. Callable from any thread and from signal
        handlers.
        """
        if self._loop.is_closed():  # closed within the `async with`: `close` is never called
            self._stop_counting_as_active()
        else:
            self._ask()

    def _stop_counting_as_active(self) -> None:
        with suppress(ValueError):
            self._on_this_thread.remove(self)

    def _turn(self) -> None:
        # While a turn runs, posts ask for no further turn; `_listen` at the end asks for one if work is left.
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
        for _ in range(len(self._ready.items) + 1):  # one turn more: `_next` may find a timer due
            source = self._next()
            if source is None:
                return
            self._perform(source)
            if not self._shutdown_signal.alive:
                return

    def _listen(self) -> None:
        """Have the next post ask for a turn, and set the loop's timer for the earliest timer entry.

        The order matters: an entry that is set after `listen` asks for a turn itself.
        """
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


class SharedLoop:
    """A block (`async with`, once) in which the running loop runs a node's callbacks.

    An error of a callback behaves like that of a task in an asyncio.TaskGroup: it cancels the body and the
    other callbacks, and the block raises it in an ExceptionGroup. The end of the block cancels the running
    callbacks and waits until they have cleaned up.
    """

    def __init__(
        self, work_queue: NodeWorkQueue, shutdown_signal: ShutdownSignal, runs: CallbackTasks
    ) -> None:
        """Make a block that keeps the running coroutine callbacks in `runs`."""
        self._runs = runs
        self._work_queue = work_queue
        self._shutdown_signal = shutdown_signal
        self._tasks: asyncio.TaskGroup | None = None
        self._engine: AsyncExecutor | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._over = asyncio.Event()

    @property
    def running(self) -> bool:
        """True while the program is inside the `async with` block."""
        return self._tasks is not None

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._tasks = await asyncio.TaskGroup().__aenter__()
        self._engine = AsyncExecutor(
            self._work_queue, self._shutdown_signal, self._tasks, self._runs, self._over.set
        )
        self._engine.open()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._tasks is not None
        assert self._engine is not None
        try:
            self._engine.close()
            self._runs.cancel_all()
            await self._tasks.__aexit__(kind, error, trace)
        finally:
            self._tasks = self._engine = self._loop = None

    async def wait(self) -> None:
        """Wait until `end` was called or the shutdown has begun."""
        await self._over.wait()

    def end(self) -> None:
        """Let `wait` return. Callable from any thread."""
        loop = self._loop
        if loop is None:
            self._over.set()
        else:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(self._over.set)
