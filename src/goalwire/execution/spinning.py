"""One thread's stay in an executor: what it watches while it spins, and what it lends while it does."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from goalwire.execution.current import HELD, THREAD
from goalwire.execution.future import Future
from goalwire.execution.work import Work

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextvars import Token
    from types import TracebackType

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.executor import Executor
    from goalwire.execution.home import Home
    from goalwire.execution.lifeline import Lifeline, Watch
    from goalwire.execution.waiting import Waiter


def settled(future: Any) -> bool:
    """Whether `future`, ours or another library's, is done or cancelled."""
    return bool(future.done() or future.cancelled())


def settled_check(future: Any) -> Callable[[], bool]:
    """A quick function that says whether `future` is settled; never true for None."""
    if future is None:
        return _never
    if isinstance(future, Future):
        return future.settled
    return partial(settled, future)


def _never() -> bool:
    return False


class Stay:
    """While it lasts, `waiter` is woken when `until` is settled or the lifeline ends.

    `executor` is what this thread runs callbacks of meanwhile; None where it only waits.
    """

    __slots__ = ('_executor', '_lifeline', '_until', '_waiter', '_watch')

    def __init__(self, executor: Executor | None, lifeline: Lifeline, waiter: Waiter, until: Any) -> None:
        self._executor = executor
        self._lifeline = lifeline
        self._waiter = waiter
        self._until = until
        self._watch: Watch | None = None

    def __enter__(self) -> None:
        wake = self._waiter.wake
        until = self._until
        if isinstance(until, Future):
            until.add_waker(wake)
        elif until is not None:
            until.add_done_callback(lambda _: wake())
        self._watch = self._lifeline.watch(wake)
        if self._executor is not None:
            THREAD.executors.append(self._executor)

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._executor is not None:
            THREAD.executors.pop()
        if self._watch is not None:
            self._watch.close()
        if isinstance(self._until, Future):
            self._until.remove_waker(self._waiter.wake)


class Loan:
    """A callback that spins lends its exclusive group, as a monitor's wait() gives up its lock.

    So the callback may wait for what only its own group can do. It goes on when the group is free again.
    """

    __slots__ = ('_entities', '_groups', '_token')

    def __init__(self) -> None:
        self._groups = HELD.get()
        self._entities = [group.active_entity for group in self._groups]
        self._token: Token[tuple[CallbackGroup, ...]] | None = None
        if self._groups:
            self._token = HELD.set(())
            for group, entity in zip(self._groups, self._entities, strict=True):
                group.ending_execution(entity)

    def take_back(self, home: Home, spin_until: Callable[[Future[None]], None]) -> None:
        """Take the groups back; `spin_until(future)` runs other work in the meantime."""
        try:
            for group, entity in zip(self._groups, self._entities, strict=True):
                while not group.beginning_execution(entity):
                    ticket = _Ticket(home)
                    group.park(ticket)
                    spin_until(ticket.free)
                    if not ticket.free.done():
                        break  # the executor was shut down: nothing runs beside this callback any more
        finally:
            if self._token is not None:
                HELD.reset(self._token)


class _Ticket(Work):
    """Stands in a group's queue for a callback that wants it back; `free` is done when its turn comes."""

    __slots__ = ('free',)

    def __init__(self, home: Home) -> None:
        super().__init__(home, None)
        self.free: Future[None] = Future()

    def run(self) -> None:
        self.free.set_result(None)
