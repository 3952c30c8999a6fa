"""Task: a function or coroutine that an executor runs, and its result (rclpy.task.Task)."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

from goalwire.execution.event_queue import CallSoon
from goalwire.execution.future import FINISHED, Future, MakesTasks
from goalwire.execution.ready_queue import CallbackSource

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from goalwire.execution.ready_queue import NodeWorkQueue

T = TypeVar('T')
Handler: TypeAlias = Callable[..., T] | Callable[..., Coroutine[Any, Any, T]] | Coroutine[Any, Any, T]


class Task(Future[T]):
    """Runs `handler(*args, **kwargs)`, or a coroutine, once; then it is done.

    An executor runs it as an asyncio task. Called by hand it runs until it is done or awaits something that
    is pending; each further call goes on from there.
    """

    __slots__ = ('_cancel_run', '_coroutine', '_executing', '_handler', '_started')

    def __init__(
        self,
        handler: Handler[T],
        args: Sequence[object] | None = None,
        kwargs: Mapping[str, object] | None = None,
        executor: MakesTasks | None = None,
    ) -> None:
        super().__init__(executor=executor)
        self._handler = (handler, tuple(args or ()), dict(kwargs or {}))
        self._coroutine: Coroutine[Any, Any, T] | None = None
        self._cancel_run: Callable[[], object] | None = None
        self._executing = False
        self._started = False

    def executing(self) -> bool:
        """True while the callback runs."""
        return self._executing

    def cancel(self) -> None:
        """Cancel the task. A coroutine that an executor runs is cancelled at the await where it waits."""
        super().cancel()
        if self._cancel_run is not None:
            self._cancel_run()

    def __call__(self) -> None:
        """Run the task without an executor: up to its end, or to an await on something pending."""
        if self.done() or self._executing:
            return
        self._executing = True
        try:
            if self._coroutine is None:
                self._begin()
            if self._coroutine is not None:
                self._await_again(self._coroutine.send(None))
        except StopIteration as end:
            self._finish(cast('T', end.value))
        except BaseException as error:
            self._discard_handler()
            self.set_exception(error)
            if not isinstance(error, Exception):
                raise
        finally:
            self._executing = False

    def begin(self, fail: Callable[[BaseException], None]) -> Coroutine[Any, Any, T | None] | None:
        """Start the task for an executor: run a function to its end, or return the coroutine to be run.

        `fail` is called with the error of the handler.
        """
        if self._started or self.cancelled():
            return None
        self._executing = True
        try:
            self._begin()
        except BaseException as error:
            self._discard_handler()
            self._fail(error, fail)
        finally:
            self._executing = False
        return None if self._coroutine is None else self._run_coroutine(self._coroutine, fail)

    def cancel_unfinished(self) -> None:
        """Cancel the task unless it has run to its end."""
        handler = self._handler[0]
        for coroutine in (self._coroutine, handler):
            if isinstance(coroutine, Coroutine):
                coroutine.close()
                self._discard_handler()
                super().cancel()

    def _begin(self) -> None:
        self._started = True
        handler, args, kwargs = self._handler
        value = handler if isinstance(handler, Coroutine) else handler(*args, **kwargs)
        if isinstance(value, Coroutine):
            self._coroutine = value
        else:
            self._finish(value)

    async def _run_coroutine(
        self, coroutine: Coroutine[Any, Any, T], fail: Callable[[BaseException], None]
    ) -> T | None:
        import asyncio

        task = asyncio.current_task()
        if task is not None:
            self._cancel_run = task.cancel
        self._executing = True
        try:
            result = await coroutine
        except asyncio.CancelledError:
            Future.cancel(self)
            raise
        except GeneratorExit:
            raise
        except BaseException as error:
            self._discard_handler()
            self._fail(error, fail)
            return None
        finally:
            self._executing = False
        self._finish(result)
        return result

    def _fail(self, error: BaseException, fail: Callable[[BaseException], None]) -> None:
        """End the task with `error`, which spin raises. `fail` is called first: whoever is woken finds the
        error there.
        """
        self._exception = error
        self.completion_state = FINISHED
        fail(error)
        self._become(FINISHED)

    def _await_again(self, awaited: object) -> None:
        """Have the executor continue the coroutine once the awaited future is done.

        Without an executor, the next call of the task continues it.
        """
        if self._work_queue is not None and isinstance(awaited, Future):
            work_queue = self._work_queue
            awaited.add_waker(lambda: work_queue.post(CallSoon(work_queue, self)))

    def _finish(self, result: T) -> None:
        self._discard_handler()
        self.set_result(result)

    def _discard_handler(self) -> None:
        """Release the handler and its arguments: a done task is kept only for its result."""
        self._coroutine = self._cancel_run = None
        self._handler = (_nothing, (), {})


def _nothing() -> Any:
    """Do nothing: this function replaces a handler that has run."""


class TaskSource(CallbackSource):
    """A task, as work for an executor."""

    __slots__ = ('_fail', 'task')

    def __init__(
        self, task: Task[Any], work_queue: NodeWorkQueue, fail: Callable[[BaseException], None]
    ) -> None:
        super().__init__(work_queue, None)
        self.task = task
        self._fail = fail

    @property
    def entity(self) -> object:
        """None: a task belongs to no entity."""
        return None

    def run(self) -> object:
        return self.task.begin(self._fail)

    def settle(self) -> None:
        self.task.cancel_unfinished()
