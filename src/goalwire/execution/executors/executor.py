"""The base class of rclpy's executors: nodes, tasks, and the ways to spin (rclpy.executors)."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterator
from functools import partial
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, Self, TypeVar, overload

from goalwire.errors import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
)
from goalwire.execution.current_callback import active_executors, held_groups
from goalwire.execution.executors.callback_runner import CallbackRunner
from goalwire.execution.executors.spin_watch import EndlessSpins
from goalwire.execution.executors.stop_conditions import (
    NEVER,
    StopWhen,
    release_groups,
    settled,
    stop_condition_of,
)
from goalwire.execution.future import Future
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.execution.shutdown_signal import ContextLike, default_context
from goalwire.execution.task import Handler, Task, TaskSource
from goalwire.execution.time.steady_clock import deadline_after
from goalwire.execution.waiters import StopCondition, WireWaiter
from goalwire.logging import get_logger
from goalwire.places import at, caller_place

if TYPE_CHECKING:
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.ready_queue import CallbackSource

__all__ = [
    'ConditionReachedException',
    'Executor',
    'ExternalShutdownException',
    'NodeLike',
    'ShutdownException',
    'TimeoutException',
    'TimeoutObject',
    'await_or_execute',
]

T = TypeVar('T')


class HandleLike(Protocol):
    """goalwire's own node, which the nodes of rclpy's API and of the asyncio API wrap."""

    @property
    def work_queue(self) -> NodeWorkQueue:
        """The queue to which the node's entities post their work."""


class NodeLike(Protocol):
    """A node as an executor sees it. `executor` is set by `add_node` and holds no strong reference.

    It has only names that rclpy's Node has, since other names may be in use in programs' subclasses of Node.
    """

    @property
    def handle(self) -> HandleLike:
        """See HandleLike."""

    @property
    def executor(self) -> Any:
        """The executor to which the node was added; None if there is none."""

    @executor.setter
    def executor(self, new_executor: Any) -> None: ...


class TimeoutObject:
    """A timeout in s that can be changed while somebody waits for it."""

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout

    @property
    def timeout(self) -> float:
        """The timeout in seconds."""
        return self._timeout

    @timeout.setter
    def timeout(self, timeout: float) -> None:
        self._timeout = timeout


Timeout = float | TimeoutObject | None


async def await_or_execute(
    callback: Callable[..., T] | Callable[..., Coroutine[Any, Any, T]], *args: object
) -> T:
    """Call `callback`, and await what it returns if that is a coroutine."""
    value = callback(*args)
    if isinstance(value, Coroutine):
        return await value
    return value


def _no_node(given: object, error: AttributeError) -> AttributeError:
    """Return an error that names what was given in place of a node.

    If the object looks like a node and lacks something else, `error` is returned unchanged.
    """
    if isinstance(given, type):
        return AttributeError(
            f'a node is needed, got the class: write {given.__name__}(), with the parentheses'
        )
    if hasattr(type(given), 'handle'):
        return error
    return AttributeError(f'a node is needed, not {given!r}')


class Executor(CallbackRunner):
    """Runs the callbacks of its nodes on the threads that spin it.

    Ready work is run in the order in which it became ready, one callback a turn. Only the execution of a goal
    overtakes other work. Spin raises the error of a callback, and the executor can spin again after that. A
    subclass may replace `spin_once`, with the help of `wait_for_ready_callbacks`; `spin` then calls it.
    """

    def __init__(self, *, context: ContextLike | None = None) -> None:
        self._context = default_context() if context is None else context
        self._is_nesting_told = False
        self._endless_spins = EndlessSpins()
        super().__init__(self._context.shutdown_signal)
        self._nodes: set[Any] = set()
        """The nodes that were added. The set keeps them alive even if the program drops them."""

    # -- nodes and tasks

    @property
    def context(self) -> ContextLike:
        """The context under which this executor spins."""
        return self._context

    def add_node(self, node: NodeLike) -> bool:
        """Run `node`'s callbacks from now on; False if this executor runs them already.

        The node leaves the executor that it was in before. Raises ShutdownException after `shutdown`.
        """
        if self._is_shutdown:
            self._refuse('add a node')
        try:
            work_queue = node.handle.work_queue
        except AttributeError as error:
            raise _no_node(node, error) from None
        ready = self._ready
        if work_queue.queue is ready:
            return False
        previous = node.executor
        self._nodes.add(node)
        if previous is self:  # the node comes back: rclpy.spin_once() adds and removes it with each call
            work_queue.attach(ready, self._timer_heap)
        else:
            if previous is not None:
                previous.remove_node(node)
            work_queue.attach(ready, self._timer_heap)
            node.executor = self
        if ready.wakers:
            ready.wake_one()
        return True

    def remove_node(self, node: NodeLike) -> None:
        """Stop running `node`'s callbacks; pending work waits for the node's next executor."""
        if self._refused:
            self._ask_again()  # so that its refused work is in the node's queue, which leaves
        self._nodes.discard(node)
        work_queue = node.handle.work_queue
        if work_queue.queue is self._ready:
            work_queue.detach()

    def get_nodes(self) -> list[Any]:
        """The nodes that were added, and neither removed nor destroyed."""
        return [node for node in list(self._nodes) if node.handle.work_queue.queue is self._ready]

    @overload
    def create_task(self, callback: Coroutine[Any, Any, T]) -> Task[T]: ...
    @overload
    def create_task(
        self, callback: Callable[..., Coroutine[Any, Any, T]], *args: object, **kwargs: object
    ) -> Task[T]: ...
    @overload
    def create_task(self, callback: Callable[..., T], *args: object, **kwargs: object) -> Task[T]: ...
    def create_task(self, callback: Handler[T], *args: object, **kwargs: object) -> Task[T]:
        """Have a function, a coroutine function or a coroutine run in this executor; the task is the future
        of its result.

        Raises ShutdownException after `shutdown`.
        """
        if self._is_shutdown:
            self._refuse('create a task')
        task: Task[T] = Task(callback, args, kwargs, executor=self)
        self.work_queue.post(TaskSource(task, self.work_queue, self._fail))
        return task

    def create_future(self) -> Future[Any]:
        """Make a future whose done callbacks run in this executor."""
        return Future(executor=self)

    @property
    def is_spinning(self) -> bool:
        """True if a thread spins this executor. A program's own subclass counts as spinning
        until `shutdown`.
        """
        return self.is_driven()

    def can_execute(self, entity: object) -> bool:
        """Tell whether the callback group of `entity` lets it run now."""
        group: CallbackGroup | None = getattr(entity, 'callback_group', None)
        return group is None or group.can_execute(entity)

    def wake(self) -> None:
        """Have a spinning thread look for work and ask the waitables for theirs. Callable from any thread."""
        self._asking = object()
        self._ask_again()
        self._ready.recheck()

    # -- spinning

    def spin(self) -> None:
        """Run callbacks until `shutdown` or the context's end.

        Raises ExternalShutdownException if the context ends during the spin, and the errors of callbacks.
        """
        while self._shutdown_signal.alive and not self._is_shutdown:
            self.spin_once()

    def spin_or_wait(self) -> None:
        """Spin as `spin` does. If another thread spins without end, wait, and take over if it leaves."""
        self.spin()

    def spin_once(self, timeout_sec: Timeout = None) -> None:
        """Run one callback, after waiting up to `timeout_sec` for it (None or negative: without limit)."""
        self._run(None, None if timeout_sec is None else self._deadline(timeout_sec), once=True)

    def spin_until_future_complete(self, future: Future[Any], timeout_sec: Timeout = None) -> None:
        """Run callbacks until `future` is done or cancelled, and the callbacks of events that came before
        that.
        """
        deadline = self._deadline(timeout_sec)
        while self._shutdown_signal.alive and not self._is_shutdown and not settled(future):
            left = None if deadline is None else (deadline - self._clock.now()) / 1e9
            if left is not None and left < 0:
                return
            self.spin_once_until_future_complete(future, left)

    def spin_once_until_future_complete(self, future: Future[Any], timeout_sec: Timeout = None) -> None:
        """Run one callback, unless `future` is done or cancelled first."""
        self._run(future, self._deadline(timeout_sec), once=True)

    def wait_for_ready_callbacks(
        self,
        timeout_sec: Timeout = None,
        nodes: list[Any] | None = None,  # noqa: ARG002
        condition: Callable[[], bool] = bool,
    ) -> tuple[Task[None], object, Any]:
        """Wait for one piece of ready work, for executors written by users.

        Returns a task that runs the work, the entity whose callback it is, and its node (both None for a
        task). `nodes` is ignored: this waits for every node of the executor. Raises TimeoutException,
        ShutdownException, ExternalShutdownException, ConditionReachedException.
        """
        self.has_spun = True
        deadline = self._deadline(timeout_sec)
        source = self._take(self._new_waiter(), StopWhen(condition), deadline)
        if source is not None:
            node = next(
                (node for node in self.get_nodes() if node.handle.work_queue is source.work_queue), None
            )
            return Task(partial(self._perform_and_raise, source)), source.entity, node
        if self._is_shutdown:
            raise ShutdownException
        if condition():
            raise ConditionReachedException
        raise TimeoutException

    def _wait_for_ready_callbacks(
        self,
        timeout_sec: Timeout = None,
        nodes: list[Any] | None = None,
        condition: Callable[[], bool] = bool,
    ) -> Iterator[tuple[Task[None], object, Any]]:
        """Yield one piece of ready work after the other; raises as wait_for_ready_callbacks does. Programs
        call this private name of rclpy.
        """
        while True:
            yield self.wait_for_ready_callbacks(timeout_sec, nodes, condition)

    def shutdown(self, timeout_sec: float | None = None) -> bool:  # noqa: ARG002
        """End every spin, remove the nodes, and return True. A callback that runs now may end later."""
        # `closed` is set first: from then on no thread falls asleep at the queue, so `wake_all` reaches all
        # sleepers.
        self._is_shutdown = self._ready.closed = True
        for node in self.get_nodes():
            self.remove_node(node)
        self._ready.wake_all()
        self._wake_workers()
        self._close_runners()
        for source in self._ready.reclaim(self.work_queue):
            if isinstance(source, TaskSource):
                source.settle()
        return True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.shutdown()

    # -- used by SingleThreadedExecutor and MultiThreadedExecutor

    def reset_in_child(self) -> None:
        super().reset_in_child()
        self._endless_spins.reset_in_child()

    def _run(self, until: Future[Any] | None, deadline: int | None, *, once: bool) -> None:
        """Spin on the calling thread."""
        stop = stop_condition_of(until)
        if not (stop.completion_state and self._has_nothing_left(once=once)):
            self._drive(self._new_waiter(), stop, deadline, once=once)

    def _has_nothing_left(self, *, once: bool) -> bool:
        """Tell whether a spin may return at once, without running callbacks, because its future is already
        done.
        """
        return (
            once
            or not self._ready.items
            or not self._shutdown_signal.alive
            or self in active_executors.executors
        )

    def thread_waits_alone(self) -> bool:
        """Tell whether the callbacks of this executor cannot run while the calling thread blocks."""
        return self in active_executors.executors

    def _wake_workers(self) -> None:
        """Wake the other threads that wait for this executor, at its shutdown. Subclasses with
        threads do so.
        """

    def add_capacity(self, count: int) -> None:
        """Do nothing. MultiThreadedExecutor allows `count` more threads, in place of those that block."""

    def _run_nested(self, stop: StopCondition, deadline: int | None, *, once: bool) -> None:
        """Spin inside a callback of this same executor, on the callback's thread."""
        if stop is NEVER and deadline is None and not once and not self._is_nesting_told:
            self._is_nesting_told = True
            get_logger('goalwire').warning(
                'rclpy.spin() was called in a callback, and never returns: remove this call; the program '
                'already spins, and goes on after the callback has returned. To wait for one answer, write '
                f"'await future' in an 'async def'{at(caller_place())}"
            )
        with release_groups(self.work_queue, self._drive_until_free):
            self._drive(self._new_waiter(), stop, deadline, once=once)

    def _drive_until_free(self, ticket: Future[None]) -> None:
        """Run callbacks until the future `ticket` is done: then the callback that spins has its
        group again.
        """
        self._drive(self._new_waiter(), ticket, None, once=False, leave_at_once=True)

    def _drive(
        self,
        waiter: WireWaiter,
        stop: StopCondition,
        deadline: int | None,
        *,
        once: bool,
        leave_at_once: bool = False,
    ) -> None:
        """Run callbacks on this thread until `stop` comes or `deadline` has passed; with `once` only one.

        Events that came before `stop` are handled, too, unless `leave_at_once`. So the callback for a goal's
        last feedback runs before the spin for its result returns.
        """
        executors = active_executors.executors
        depth, held = len(executors), held_groups.get()
        self.has_spun = True
        try:
            executors.append(self)
            if stop is not NEVER:
                stop.add_waker(waiter.wake)
            if not stop.completion_state:
                self._run_callbacks(waiter, stop, deadline, once=once)
            if self._ready.items and not (once or leave_at_once) and stop.completion_state:
                self._work_off(deadline)
        finally:
            del executors[depth:]
            if held_groups.get() is not held:
                held_groups.set(held)
            if stop is not NEVER and not stop.completion_state:  # a completed future has dropped its wakers
                stop.remove_waker(waiter.wake)

    def _deadline(self, timeout: Timeout) -> int | None:
        return deadline_after(self._clock, timeout.timeout if isinstance(timeout, TimeoutObject) else timeout)

    def _refuse(self, what: str) -> NoReturn:
        raise ShutdownException(f'cannot {what}: this executor was shut down; make a new one')

    def _perform_and_raise(self, source: CallbackSource) -> None:
        held = held_groups.get()
        try:
            self._perform(source)
        finally:
            held_groups.set(held)
        self._raise_failure()
