"""Future: a result that comes later, as rclpy.task.Future. Any thread may complete it."""

from __future__ import annotations

import sys
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, cast

from goalwire.execution.current_callback import active_executors
from goalwire.execution.ready_queue import CallbackSource
from goalwire.execution.time.steady_clock import STEADY, SteadyClock
from goalwire.execution.waiters import Waiter, running_loop

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal

if TYPE_CHECKING:
    from typing_extensions import TypeVar as TypeVarWithDefault

    T = TypeVarWithDefault('T', default=Any)  # so `Future` alone means Future[Any], as in rclpy
else:
    T = TypeVar('T')

PENDING, _CANCELLED, FINISHED = range(3)


class _Reminder:
    """Prints the exception of a future that is garbage collected before the exception was retrieved."""

    __slots__ = ('exception', 'retrieved')

    def __init__(self, exception: object) -> None:
        self.exception = exception
        self.retrieved = False

    def __del__(self) -> None:
        if not self.retrieved and sys.stderr is not None:
            print(f'The following exception was never retrieved: {self.exception}', file=sys.stderr)  # noqa: T201


class _DoneCallback(CallbackSource):
    """A user's done callback, as work for an executor."""

    __slots__ = ('_callback', '_future')

    def __init__(
        self, work_queue: NodeWorkQueue, callback: Callable[[Future[T]], object], future: Future[T]
    ) -> None:
        super().__init__(work_queue, None)
        self._callback = callback
        self._future = future

    @property
    def call(self) -> tuple[Callable[..., object], Future[Any]]:
        """The done callback and its argument."""
        return self._callback, self._future

    def run(self) -> object:
        return self._callback(self._future)


def _advise(callback: object) -> None:
    """Log that `callback` cannot be called. The call will raise TypeError, as in rclpy."""
    from goalwire.execution.callback_arguments import advise_callback  # imported here: rarely needed
    from goalwire.logging import get_logger

    advise_callback(callback, ('future',), 'the done callback of a future', get_logger('rclpy.task'))


class MakesTasks(Protocol):
    """The method that a future needs of an executor that is not goalwire's."""

    def create_task(self, callback: Callable[..., object], /, *args: object) -> object:
        """Have the executor call `callback(*args)`."""


class _ForeignWorkQueue:
    """The work queue of a future that belongs to an executor that goalwire did not make."""

    __slots__ = ('_executor',)

    def __init__(self, executor: MakesTasks) -> None:
        self._executor = executor

    def post(self, source: CallbackSource) -> None:
        """Have the executor run this source."""
        if isinstance(source, _DoneCallback):
            self._executor.create_task(*source.call)
        else:
            self._executor.create_task(source.run)

    def executor(self) -> MakesTasks:
        """Return the executor to which this queue belongs."""
        return self._executor


def _work_queue_of(executor: MakesTasks) -> NodeWorkQueue:
    work_queue: NodeWorkQueue | None = getattr(executor, 'work_queue', None)
    return cast('NodeWorkQueue', _ForeignWorkQueue(executor)) if work_queue is None else work_queue


class Future(Generic[T]):
    """A result to come. As in rclpy a cancelled future is not `done`, and a result may be set again.

    No lock is taken, and no waker is forgotten, because both sides act in opposite order. The completing
    thread sets the state, then calls the wakers. A waiting thread appends its waker, then looks at the state.
    One of them sees the other, and `list.pop` gives each waker to one thread only.

    Wakers are functions of this library. They are short and run on the completing thread. Done callbacks are
    functions of the user. The future's executor calls them, in the order in which they were added; a future
    without an executor calls them at once.

    `completion_state` is 0 while the future is pending, and then tells how it ended. Spins look at it
    directly.
    """

    __slots__ = (
        '__dict__',  # programs may set attributes of their own
        '__weakref__',
        '_callbacks',
        '_exception',
        '_raw',
        '_result',
        '_wakers',
        '_work_queue',
        'completion_state',
    )

    _reminder: _Reminder | None = None
    """Set together with an exception; None after the exception was retrieved."""

    def __init__(
        self, work_queue: NodeWorkQueue | None = None, /, *, executor: MakesTasks | None = None
    ) -> None:
        """Make a future of `executor`, as in rclpy, of the executor that runs `work_queue`, or of none.

        Any object with a `create_task` may be the executor.
        """
        self.completion_state = PENDING
        self._result: T | None = None
        self._exception: BaseException | None = None
        self._raw: object = None
        self._wakers: list[Callable[[], None]] = []
        self._callbacks: list[Callable[[Future[T]], object]] = []
        self._work_queue = work_queue if executor is None else _work_queue_of(executor)

    def __getattr__(self, name: str) -> Any:
        """Raise an AttributeError which says that the result has the attribute, not the future."""
        text = f'{type(self).__name__!r} object has no attribute {name!r}'
        if name[:1] != '_':
            text += (
                ': this is a future, whose result comes later; wait for it, by '
                "rclpy.spin_until_future_complete(node, future) or 'await', and then write "
                f'future.result().{name}'
            )
        raise AttributeError(text, name=name, obj=self)

    # -- methods of rclpy's Future

    def done(self) -> bool:
        """Tell whether the future has a result or an exception."""
        return self.completion_state == FINISHED

    def cancelled(self) -> bool:
        """Tell whether the future was cancelled before it was done."""
        return self.completion_state == _CANCELLED

    def result(self) -> T | Any:
        """Return the result, or None while there is none; raise the exception if the future has one.

        The annotation leaves None out, because programs call this when they know that the future is done.
        """
        raw = self._raw
        if raw is not None:  # hot path: a separate function for the decoding would take 0.6 us a call
            result, failure = None, None
            try:
                result = self.decode(raw)
            except Exception as error:
                failure = error.with_traceback(None)  # the traceback's frames would keep the payload alive
            if self._raw is raw:  # if several threads decode at once, the first result is kept
                self._result, self._exception = result, failure
                self._raw = None
            raw = failure = None
        exception = self._exception
        if exception is not None:
            self._mark_retrieved()
            try:
                raise exception
            finally:  # break the circle of the exception, its traceback and this frame
                del exception, self
        return self._result

    def exception(self) -> BaseException | None:
        """Return the future's exception; None if it has none."""
        if self._raw is not None:
            with suppress(Exception):  # `result` also keeps the exception in `_exception`
                self.result()
            if self._exception is not None:
                self._exception.__traceback__ = None  # the traceback would keep this frame alive
        self._mark_retrieved()
        return self._exception

    def set_result(self, result: T) -> None:
        """Complete the future. An exception that was set before stays, as in rclpy. Callable from
        any thread.
        """
        self._raw = None
        self._result = result
        self._become(FINISHED)

    def set_exception(self, exception: BaseException) -> None:
        """Complete the future with an exception, which `result` raises. Callable from any thread."""
        self._raw = None
        self._exception = exception
        self._mark_retrieved()
        self._reminder = _Reminder(exception)
        self._become(FINISHED)

    def cancel(self) -> None:
        """Cancel the future, if it is pending."""
        if self.completion_state == PENDING:
            self._become(_CANCELLED)

    def add_done_callback(self, callback: Callable[[Future[T]], object]) -> None:
        """Have `callback(self)` called when this is done or cancelled; soon or at once if it already is."""
        given: object = callback
        if not callable(given):
            _advise(given)
        if self.completion_state == PENDING:
            self._callbacks.append(callback)
            if self.completion_state != PENDING:
                self._tell()
        elif self._work_queue is not None:
            self._work_queue.post(_DoneCallback(self._work_queue, callback, self))
        else:
            callback(self)

    def __await__(self) -> Generator[object, None, T | Any]:
        """Wait in a coroutine: in an asyncio task, or in a `Task` driven by hand.

        Awaiting a cancelled future gives None, as in newer rclpy.
        """
        while self.completion_state == PENDING:
            loop = running_loop()
            if loop is None:
                yield self
            else:
                from goalwire.execution.asyncio.loop_waker import wait_on  # not at the top: imports asyncio

                yield from wait_on(loop, self)
        try:
            return self.result()
        finally:
            del self  # as in `result`

    # -- methods for goalwire itself

    def pending(self) -> bool:
        """Tell whether the future is neither done nor cancelled."""
        return self.completion_state == PENDING

    def settled(self) -> bool:
        """Tell whether the future is done or cancelled."""
        return self.completion_state != PENDING

    def set_raw(self, raw: object) -> bool:
        """Complete the future with a payload; `decode` makes the result of it when `result` is called.

        Returns False if no thread or coroutine waits for the future, and it has no done callback.
        """
        self._raw = raw
        self.completion_state = FINISHED
        return self._tell()

    def add_waker(self, waker: Callable[[], None]) -> None:
        """Have `waker` called once, on the completing thread; at once if the future is not pending."""
        self._wakers.append(waker)
        if self.completion_state != PENDING:
            self._tell()

    def remove_waker(self, waker: Callable[[], None]) -> None:
        """Remove a waker. It may still be called if another thread is completing the future."""
        try:
            self._wakers.remove(waker)
        except ValueError:
            return  # the completing thread has taken it out, and calls it

    def set_work_queue(self, work_queue: NodeWorkQueue) -> None:
        """Have the done callbacks run in the executor of `work_queue`."""
        self._work_queue = work_queue

    def wait(
        self,
        deadline: int | None = None,
        *,
        clock: SteadyClock = STEADY,
        shutdown_signal: ShutdownSignal | None = None,
    ) -> bool:
        """Block until it is done or cancelled (True); False at `deadline` (steady ns) or the shutdown.

        No executor has to spin: the completing thread wakes the waiting thread.
        """
        if self.completion_state != PENDING:
            return True
        waiter = Waiter() if shutdown_signal is None else shutdown_signal.borrow_waiter()
        wake = waiter.wake
        self._wakers.append(wake)
        try:
            while self.completion_state == PENDING and (shutdown_signal is None or shutdown_signal.alive):
                if not clock.wait(waiter, deadline):
                    break
        finally:
            if self._wakers:
                self.remove_waker(wake)
            if shutdown_signal is not None:
                shutdown_signal.idle_waiters.append(waiter)
        return self.completion_state != PENDING

    def decode(self, raw: object, /) -> T:
        """Return the result that the payload of `set_raw` stands for. Subclasses override this method."""
        return cast('T', raw)

    def _executor(self) -> object:
        """Return the executor that runs the done callbacks; None if there is none. Programs read this private
        name of rclpy.
        """
        return None if self._work_queue is None else self._work_queue.executor()

    def _set_executor(self, executor: MakesTasks | None) -> None:
        self._work_queue = None if executor is None else _work_queue_of(executor)

    def _mark_retrieved(self) -> None:
        reminder = self._reminder
        if reminder is not None:
            reminder.retrieved = True
            self._reminder = None

    def _become(self, state: int) -> None:
        self.completion_state = state
        self._tell()

    def _tell(self) -> bool:
        """Call the remaining wakers, then the done callbacks; False if there were none.

        hot path: it runs between the arrival of a reply and the wake-up of the waiting thread. So the loop
        over the wakers has no function of its own (0.6 us less a call).
        """
        wakers = self._wakers
        told = False
        while wakers:
            try:
                waker = wakers.pop(0)
            except IndexError:
                break
            waker()
            told = True
        if self._callbacks:
            self._call_back()
            told = True
        return told

    def _call_back(self) -> None:
        while self._callbacks:
            try:
                callback = self._callbacks.pop(0)
            except IndexError:
                return
            work_queue = self._work_queue
            if work_queue is not None:
                work_queue.post(_DoneCallback(work_queue, callback, self))
                continue
            try:
                callback(self)
            except Exception as error:
                warnings.warn(f'Unhandled exception in done callback: {error}', stacklevel=4)


def block_on(future: Future[Any], deadline: int | None, shutdown_signal: ShutdownSignal) -> bool:
    """Block until `future` is settled (True); False at `deadline` (steady ns) or the shutdown."""
    executors = active_executors.executors
    if not executors:
        return future.wait(deadline, clock=shutdown_signal.clock, shutdown_signal=shutdown_signal)
    if future.settled():
        return True
    executor = executors[-1]
    executor.add_capacity(1)
    try:
        return future.wait(deadline, clock=shutdown_signal.clock, shutdown_signal=shutdown_signal)
    finally:
        executor.add_capacity(-1)


def cancel_quietly(future: Future[Any]) -> None:
    """Cancel a future without a later warning about its exception, after a wait for it was interrupted."""
    future.cancel()
    future.exception()
