"""One thread's spin: the conditions that end it, and the callback groups that it releases meanwhile."""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from goalwire.execution.current_callback import held_groups
from goalwire.execution.event_queue import CallSoon
from goalwire.execution.future import Future
from goalwire.execution.waiters import StopCondition

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import TracebackType

    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal, ShutdownWatch
    from goalwire.execution.waiters import Waiter


def settled(future: Any) -> bool:
    """Tell whether `future`, of this or another library, is done or cancelled."""
    return bool(future.done() or future.cancelled())


class StopWhen:
    """A stop condition that calls a function at each look.

    The code that makes the function return True has to wake the sleeping thread itself.
    """

    __slots__ = ('_ask',)

    def __init__(self, ask: Callable[[], bool]) -> None:
        self._ask = ask

    @property
    def completion_state(self) -> object:
        return self._ask()

    def add_waker(self, waker: Callable[[], None]) -> None:
        """Do nothing: other code wakes the sleeping thread."""

    def remove_waker(self, waker: Callable[[], None]) -> None:
        """Do nothing."""


class _ForeignFuture(StopWhen):
    """The stop condition that comes when a future of another library is done."""

    __slots__ = ('_future',)

    def __init__(self, future: Any) -> None:
        super().__init__(partial(settled, future))
        self._future = future

    def add_waker(self, waker: Callable[[], None]) -> None:
        self._future.add_done_callback(lambda _: waker())


class _Never(StopWhen):
    """The stop condition of `rclpy.spin`, which never comes."""

    __slots__ = ()

    completion_state = False


NEVER = _Never(bool)


def stop_condition_of(until: Any) -> StopCondition:
    """Return the condition that ends a spin when a future is settled; None: no condition."""
    if isinstance(until, Future):
        return until
    return NEVER if until is None else _ForeignFuture(until)


class StopConditionScope:
    """A block (`with`) in which `waiter` is woken when `stop` comes or the shutdown begins."""

    __slots__ = ('_shutdown_signal', '_stop', '_waiter', '_watch')

    def __init__(self, shutdown_signal: ShutdownSignal, waiter: Waiter, stop: StopCondition) -> None:
        self._shutdown_signal = shutdown_signal
        self._waiter = waiter
        self._stop = stop
        self._watch: ShutdownWatch | None = None

    def __enter__(self) -> None:
        self._stop.add_waker(self._waiter.wake)
        self._watch = self._shutdown_signal.watch(self._waiter.wake)

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._watch is not None:
            self._watch.close()
        self._stop.remove_waker(self._waiter.wake)


@contextmanager
def release_groups(work_queue: NodeWorkQueue, spin_until: Callable[[Future[None]], None]) -> Iterator[None]:
    """Release the exclusive group of a callback that spins, as a monitor's wait() gives up its lock.

    So the callback may wait for other callbacks of its own group. At the end of the block it takes the group
    again. If the group is not free by then, `spin_until(future)` runs other work until it is.
    """
    groups = held_groups.get()
    if not groups:
        yield
        return
    entities = [group.active_entity for group in groups]
    token = held_groups.set(())
    for group, entity in zip(groups, entities, strict=True):
        group.ending_execution(entity)
    try:
        yield
    finally:
        try:
            for group, entity in zip(groups, entities, strict=True):
                while not group.beginning_execution(entity):
                    free: Future[None] = Future()
                    group.park(CallSoon(work_queue, partial(free.set_result, None)))
                    spin_until(free)
                    if not free.done():
                        break  # the executor was shut down: no other callback of the group starts any more
        finally:
            held_groups.reset(token)
