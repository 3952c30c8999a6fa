"""Waitable: what a program adds to an executor as a source of callbacks of its own (rclpy.waitable)."""

from __future__ import annotations

from collections.abc import Coroutine
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

if TYPE_CHECKING:
    from types import TracebackType

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.event_queue import EventQueue
    from goalwire.execution.future import Future
    from goalwire.execution.wait_set import WaitSet

T = TypeVar('T')


class NumberOfEntities:
    """How many entities of each kind a waitable waits for. Adding two of them gives a third."""

    __slots__ = (
        'num_clients',
        'num_events',
        'num_guard_conditions',
        'num_services',
        'num_subscriptions',
        'num_timers',
    )

    def __init__(
        self,
        num_subs: int = 0,
        num_gcs: int = 0,
        num_timers: int = 0,
        num_clients: int = 0,
        num_services: int = 0,
        num_events: int = 0,
    ) -> None:
        self.num_subscriptions = num_subs
        self.num_guard_conditions = num_gcs
        self.num_timers = num_timers
        self.num_clients = num_clients
        self.num_services = num_services
        self.num_events = num_events

    def _counts(self) -> tuple[int, ...]:
        """In the order of the constructor's parameters."""
        return (
            self.num_subscriptions,
            self.num_guard_conditions,
            self.num_timers,
            self.num_clients,
            self.num_services,
            self.num_events,
        )

    def __add__(self, other: NumberOfEntities) -> NumberOfEntities:
        return NumberOfEntities(
            *(mine + theirs for mine, theirs in zip(self._counts(), other._counts(), strict=True))
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NumberOfEntities) and self._counts() == other._counts()

    __hash__ = None  # type: ignore[assignment]  # it can be changed

    def __repr__(self) -> str:
        return f'NumberOfEntities{self._counts()}'


class Waitable(Generic[T]):
    """Waits for several entities at once and runs one callback for all of them.

    To be derived from, and added with `Node.add_waitable`. Each time an executor looks for work it asks
    `add_to_wait_set`, then `is_ready`; where that is true it calls `take_data` and awaits `execute`, both
    under the rule of the callback group. Used as a context while it is asked: what raises InvalidHandle on
    entering is not ready.
    """

    def __init__(self, callback_group: CallbackGroup) -> None:
        self.callback_group = callback_group
        callback_group.add_entity(self)
        self._futures: list[Future[Any]] = []

    def __enter__(self) -> object:
        """Keep what is waited for alive meanwhile."""
        return self

    def __exit__(
        self, t: type[BaseException] | None, v: BaseException | None, tb: TracebackType | None
    ) -> None:
        """Keep it no longer."""

    def add_future(self, future: Future[Any]) -> None:
        """Let the done callbacks of `future` run in the executor that runs this."""
        self._futures.append(future)

    def remove_future(self, future: Future[Any]) -> None:
        """Forget `future`; raises ValueError where it was not added."""
        self._futures.remove(future)

    def is_ready(self, wait_set: WaitSet) -> bool:
        """Whether there is something to execute."""
        raise NotImplementedError(f'{type(self).__name__} must say whether it is_ready(wait_set)')

    def take_data(self) -> T:
        """Take what `execute` shall get, so that this is ready no more."""
        raise NotImplementedError(f'{type(self).__name__} must have a take_data()')

    async def execute(self, taken_data: T) -> None:
        """Do the work, with what `take_data` returned."""
        raise NotImplementedError(f'{type(self).__name__} must have an execute(taken_data)')

    def get_num_entities(self) -> NumberOfEntities:
        """How many entities `add_to_wait_set` adds."""
        raise NotImplementedError(f'{type(self).__name__} must have a get_num_entities()')

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add what to wait for, and keep the indices."""
        raise NotImplementedError(f'{type(self).__name__} must have an add_to_wait_set(wait_set)')


class SelfDriven(Waitable[T]):
    """A waitable whose entities post their work themselves: executors never ask it. goalwire's own are."""

    def destroy(self) -> None:
        """Release what it holds. Idempotent."""
        raise NotImplementedError


class EventQueueWaitable(SelfDriven['tuple[EventQueue[Any], Any] | None']):
    """Something with several event queues. Its methods do by hand, one by one, what executors do alone.

    Used as a context it is destroyed at the block's end.
    """

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, t: type[BaseException] | None, v: BaseException | None, tb: TracebackType | None
    ) -> None:
        self.destroy()

    def event_queues(self) -> list[EventQueue[Any]]:
        """Where its events wait."""
        raise NotImplementedError

    def is_ready(self, wait_set: WaitSet) -> bool:  # noqa: ARG002
        """Whether an event waits."""
        return any(event_queue.events for event_queue in self.event_queues())

    def take_data(self) -> tuple[EventQueue[Any], Any] | None:
        """Take one event, so that no executor will; None where there is none."""
        for event_queue in self.event_queues():
            event = event_queue.take()
            if event is not None:
                return event_queue, event
        return None

    async def execute(self, taken_data: tuple[EventQueue[Any], Any] | None) -> None:
        """Run the callback for an event that was taken."""
        if taken_data is not None:
            event_queue, event = taken_data
            outcome = event_queue.handle(event)
            if isinstance(outcome, Coroutine):
                await outcome
