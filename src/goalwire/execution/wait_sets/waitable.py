"""Waitables: callback sources that a program writes itself and adds to a node (rclpy.waitable)."""

from __future__ import annotations

from _thread import allocate_lock
from collections.abc import Coroutine
from contextlib import ExitStack
from threading import Lock
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol, Self, TypeVar, cast

from goalwire.errors import InvalidHandle
from goalwire.execution.rclpy_handle import entity_of
from goalwire.execution.ready_queue import CallbackSource
from goalwire.execution.time.clock import ClockTimerEntry

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.event_queue import EventQueue
    from goalwire.execution.future import Future
    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.execution.time.timer import Timer

Kind = Literal['subscription', 'guard_condition', 'timer', 'client', 'service', 'event']
_KINDS: tuple[Kind, ...] = ('subscription', 'guard_condition', 'timer', 'client', 'service', 'event')


class Waited(Protocol):
    """An entity that a wait set can hold. It calls all of `watchers` with each event, on any thread."""

    watchers: Sequence[Callable[[], None]]

    @property
    def counts_up(self) -> bool:
        """True if `events` counts all events so far; False if it counts only the waiting events."""

    @property
    def events(self) -> int:
        """The number of events; see `counts_up`."""


_watching = Lock()
"""The lock for changes of `watchers`."""


def watch(entity: Waited, wake: Callable[[], None]) -> None:
    """Have `wake()` called at each event of `entity`, on any thread."""
    with _watching:
        entity.watchers = (*entity.watchers, wake)


def unwatch(entity: Waited, wake: Callable[[], None]) -> None:
    """Remove `wake`. Does nothing if it was not added."""
    with _watching:
        entity.watchers = tuple(other for other in entity.watchers if other != wake)


class WaitSet:
    """Entities by kind and index, and which of them were ready at the last `look`."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._entities: dict[str, list[Waited]] = {kind: [] for kind in _KINDS}
        self._ready: dict[str, list[bool]] = {kind: [] for kind in _KINDS}
        self._seen: dict[Waited, int] = {}
        """The watched entities, each with its number of events at the last look."""

    # -- methods of rclpy's WaitSet

    def add_subscription(self, handle: object) -> int:
        """Add a subscription, and return its index for `is_ready`."""
        return self._add('subscription', handle)

    def add_guard_condition(self, handle: object) -> int:
        """Add a guard condition, which is ready in the first look after it was triggered."""
        return self._add('guard_condition', handle)

    def add_timer(self, handle: object) -> int:
        """Add a timer, which is ready from its due time until `call_timer`."""
        return self._add('timer', handle)

    def add_client(self, handle: object) -> int:
        """Add a client, which is ready in the first look after a response has come."""
        return self._add('client', handle)

    def add_service(self, handle: object) -> int:
        """Add a service, which is ready while requests wait."""
        return self._add('service', handle)

    def add_event(self, handle: object) -> int:
        """Add an event, which is ready while there is data to take."""
        return self._add('event', handle)

    def is_ready(self, entity_type: Kind, index: int) -> bool:
        """Tell whether an entity was ready; raises RuntimeError for an unknown kind, IndexError for an
        unknown index.
        """
        ready = self._ready.get(entity_type)
        if ready is None:
            raise RuntimeError(f"'{entity_type}' is not a known entity: ask for one of {', '.join(_KINDS)}")
        if not 0 <= index < len(ready):
            raise IndexError(f'no {entity_type} was added under the index {index}: there are {len(ready)}')
        return ready[index]

    # -- methods for executors

    def clear(self) -> None:
        """Remove all members, so that they can be added anew."""
        for entities in self._entities.values():
            entities.clear()

    def look(self) -> None:
        """Watch exactly the members, and note which of them are ready."""
        wanted = {entity for entities in self._entities.values() for entity in entities}
        for entity in wanted - self._seen.keys():
            self._seen[entity] = self._first_count(entity)
            # `watch` comes before the count: a later event calls `wake`, and an earlier event is counted.
            watch(entity, self._wake)
        for entity in self._seen.keys() - wanted:
            del self._seen[entity]
            unwatch(entity, self._wake)
        counts = {entity: entity.events for entity in wanted}
        for kind, entities in self._entities.items():
            self._ready[kind] = [self._is_ready(entity, counts[entity]) for entity in entities]
        self._seen = counts

    def close(self) -> None:
        """Stop watching."""
        self.clear()
        self.look()

    @property
    def timers(self) -> Sequence[Timer]:
        """The timers among the members."""
        return cast('list[Timer]', self._entities['timer'])

    def _first_count(self, entity: Waited) -> int:  # noqa: ARG002
        """Return the number of events of a new member that this wait set does not report."""
        return 0

    def _is_ready(self, entity: Waited, events: int) -> bool:
        return events != self._seen[entity] if entity.counts_up else events > 0

    def _add(self, kind: Kind, handle: object) -> int:
        found: Any = entity_of(handle)
        entity: Waited = getattr(found, 'event_queue', found)
        if not hasattr(entity, 'watchers'):
            raise TypeError(
                f'add_{kind}() takes the handle of a {kind.replace("_", " ")}, got {type(handle).__name__}'
            )
        entities = self._entities[kind]
        entities.append(entity)
        return len(entities) - 1


T = TypeVar('T')


class NumberOfEntities:
    """The numbers of entities of each kind that a waitable waits for. `+` adds two of these."""

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
        """The numbers in the order of the constructor's parameters."""
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

    Programs write subclasses and add them by `Node.add_waitable`. Each time an executor looks for work, it
    calls `add_to_wait_set`, then `is_ready`. If that returns True, it calls `take_data` and awaits `execute`,
    both under the rule of the callback group. The calls before that are made in `with waitable:`; if entering
    raises InvalidHandle, the waitable is not ready.
    """

    def __init__(self, callback_group: CallbackGroup) -> None:
        self.callback_group = callback_group
        callback_group.add_entity(self)
        self._futures: list[Future[Any]] = []

    def __enter__(self) -> object:
        """Keep the members alive while an executor asks."""
        return self

    def __exit__(
        self, t: type[BaseException] | None, v: BaseException | None, tb: TracebackType | None
    ) -> None:
        """Release the members."""

    def add_future(self, future: Future[Any]) -> None:
        """Have the done callbacks of `future` run in the executor that runs this waitable."""
        self._futures.append(future)

    def remove_future(self, future: Future[Any]) -> None:
        """Remove `future` from the added futures; raises ValueError if it was not added."""
        self._futures.remove(future)

    def run_futures_in(self, work_queue: NodeWorkQueue) -> None:
        """Have the done callbacks of all added futures run in the executor of `work_queue`."""
        for future in self._futures:
            future.set_work_queue(work_queue)

    def is_ready(self, wait_set: WaitSet) -> bool:
        """Tell whether there is something to execute."""
        raise NotImplementedError(f'{type(self).__name__} must say whether it is_ready(wait_set)')

    def take_data(self) -> T:
        """Take the data for `execute` out, so that this waitable is not ready any longer."""
        raise NotImplementedError(f'{type(self).__name__} must have a take_data()')

    async def execute(self, taken_data: T) -> None:
        """Do the work with the data of `take_data`."""
        raise NotImplementedError(f'{type(self).__name__} must have an execute(taken_data)')

    def get_num_entities(self) -> NumberOfEntities:
        """Return the numbers of entities that `add_to_wait_set` adds."""
        raise NotImplementedError(f'{type(self).__name__} must have a get_num_entities()')

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the entities to wait for to the wait set, and keep their indices."""
        raise NotImplementedError(f'{type(self).__name__} must have an add_to_wait_set(wait_set)')


class SelfDriven(Waitable[T]):
    """A waitable whose entities post their work themselves, so executors never ask it. goalwire's own
    waitables are of this kind.
    """

    def destroy(self) -> None:
        """Release what the waitable holds. Idempotent."""
        raise NotImplementedError


class EventQueueWaitable(SelfDriven['tuple[EventQueue[Any], Any] | None']):
    """A waitable with several event queues. Programs may call its methods in place of an executor.

    `with waitable:` destroys it at the end of the block.
    """

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, t: type[BaseException] | None, v: BaseException | None, tb: TracebackType | None
    ) -> None:
        self.destroy()

    def event_queues(self) -> list[EventQueue[Any]]:
        """The event queues of this waitable."""
        raise NotImplementedError

    def is_ready(self, wait_set: WaitSet) -> bool:  # noqa: ARG002
        """Tell whether an event waits."""
        return any(event_queue.events for event_queue in self.event_queues())

    def take_data(self) -> tuple[EventQueue[Any], Any] | None:
        """Take one event out, so that no executor runs its callback; None if there is none."""
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


class WaitablePoller(CallbackSource):
    """Asks one waitable whether it is ready, each time before the executor takes work or goes to sleep.

    One thread at a time asks. A thread that comes meanwhile sets `_missed`, and the asking thread then asks
    again. Spin raises an exception of the waitable, whether it comes from asking or from running.
    """

    __slots__ = (
        '_asking',
        '_closed',
        '_error',
        '_found',
        '_missed',
        '_timer_entries',
        '_wait_set',
        'waitable',
    )

    def __init__(self, work_queue: NodeWorkQueue, waitable: Waitable[Any]) -> None:
        super().__init__(work_queue, waitable.callback_group)
        self.waitable = waitable
        self._wait_set = WaitSet(self.wake)
        self._timer_entries: dict[Timer, ClockTimerEntry] = {}
        self._asking = allocate_lock()
        self._missed = self._found = self._closed = False
        self._error: BaseException | None = None

    @property
    def entity(self) -> object:
        """The waitable."""
        return self.waitable

    def wake(self) -> None:
        """Have the executor look at the waitable. Callable from any thread."""
        queue = self.work_queue.queue
        if queue is not None:
            queue.recheck()

    def look(self) -> None:
        """Ask the waitable, and post this poller if it is ready. Does nothing while this poller is posted or
        its group is busy.
        """
        self._missed = True
        while self._missed:
            if not self._asking.acquire(blocking=False):
                if self._asking.locked():
                    return  # the other thread reads `_missed` after it has released the lock, and asks again
                continue
            try:
                self._missed = False
                self._look_alone()
            finally:
                self._asking.release()

    def run(self) -> object:
        error, self._error = self._error, None
        waitable = self.waitable
        try:
            if error is not None:
                raise error
            if self._closed:
                return None
            data = waitable.take_data()
        finally:
            self._found = False
        waitable.run_futures_in(self.work_queue)
        return waitable.execute(data)

    def close(self) -> None:
        """Stop asking. If another thread asks at this moment, that thread closes the wait set."""
        self._closed = True
        self.look()

    def _look_alone(self) -> None:
        if self._closed:
            self._wait_set.close()
            self._follow_timers()
        elif not self._found and (self.group is None or self.group.can_execute(self.waitable)):
            self._found = self._ask()
            if self._found:
                self.work_queue.post(self)

    def _ask(self) -> bool:
        # An error of the program's methods counts as ready: `run` then raises it on the spinning thread.
        waitable, wait_set = self.waitable, self._wait_set
        try:
            with ExitStack() as held:
                try:
                    held.enter_context(waitable)
                except InvalidHandle:
                    return False  # the waitable is being destroyed; rclpy skips it, too
                wait_set.clear()
                waitable.add_to_wait_set(wait_set)
                wait_set.look()
                self._follow_timers()
                return bool(waitable.is_ready(wait_set))
        except BaseException as error:
            self._error = error
            return True

    def _follow_timers(self) -> None:
        """Set entries that wake the executor when the timers of the wait set are due.

        Jumps of a clock need no entry: the timer itself calls its watchers then.
        """
        timers = self._wait_set.timers
        for timer in self._timer_entries.keys() - set(timers):
            self._timer_entries.pop(timer).cancel()
        for timer in timers:
            entry = self._timer_entries.get(timer)
            if entry is None:
                entry = self._timer_entries[timer] = ClockTimerEntry(self.work_queue, timer.clock, self.wake)
            if timer.is_canceled() or timer.is_ready():
                entry.cancel()
            elif entry.time != timer.next_call_ns:
                entry.set(timer.next_call_ns)
