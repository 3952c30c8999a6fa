"""Two sources of callbacks: the event queue of a subscription, service or client, and the guard condition."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.errors import InvalidHandle
from goalwire.execution.handle import handle_of
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue
from goalwire.execution.weak_methods import weak_parts

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.waiting import ContextLike

E = TypeVar('E')

TICKS_LIMIT = 1000
"""Turns that one client saves up for spins to come; a program that never spins needs none."""


class EventQueue(CallbackSource, Generic[E]):
    """Events that wait for their callback, `depth` of them at most (None: without limit).

    When it is full, the oldest event is dropped; if there is a `refuse`, that gets the new one instead.
    `dropped` counts both. However many events wait, the event queue is in the executor's queue once.
    """

    __slots__ = (
        '_alone',
        '_events',
        '_function',
        '_handle',
        '_object',
        '_posted',
        '_refuse',
        'closed',
        'depth',
        'dropped',
        'note',
        'watchers',
    )

    counts_up = False

    def __init__(
        self,
        work_queue: NodeWorkQueue,
        group: CallbackGroup | None,
        handle: Callable[[E], object],
        *,
        depth: int | None = None,
        refuse: Callable[[E], object] | None = None,
    ) -> None:
        """`refuse` gets the events that come after `close`, on the thread that brings them."""
        super().__init__(work_queue, group)
        self.depth = depth
        self.dropped = 0
        self.closed = False
        self.note: Callable[[E], object] | None = None
        """Is told of each event before it is queued."""
        self.watchers: Sequence[Callable[[], None]] = ()
        # A bound method is held weakly: the wire holds this queue, and must not hold the entity.
        self._handle: Callable[[E], object] | None = None
        parts = weak_parts(handle)
        if parts is None:
            self._handle = handle
        else:
            self._object, self._function = parts
        self._events: deque[E] = deque(maxlen=depth if refuse is None else None)
        self._refuse = refuse
        self._posted = False
        self._alone = group is not None and group.exclusive

    def __len__(self) -> int:
        return len(self._events)

    def __bool__(self) -> bool:
        return True

    @property
    def entity(self) -> object:
        """The entity whose events these are."""
        owner = self._object() if self._handle is None else getattr(self._handle, '__self__', None)
        return getattr(owner, 'entity', owner)

    @property
    def backlog(self) -> int:
        return len(self._events)

    @property
    def events(self) -> int:
        """How many events wait; see waitable.Waited."""
        return len(self._events)

    def deliver(self, event: E) -> None:
        """Queue `event`. Any thread; short, takes no lock. What a transport calls with all that comes.

        The append comes before the look at `_posted`, and `_go_on` resets that before it looks for events.
        """
        if self.note is not None:
            self.note(event)
        events = self._events
        if self.depth is not None and len(events) >= self.depth:
            self.dropped += 1
            if self._refuse is not None:
                self._refuse(event)
                return
        if self.closed:
            if self._refuse is not None:
                self._refuse(event)
            return
        events.append(event)
        if not self._posted:
            self._posted = True
            try:
                self.work_queue.post(self)
            except BaseException:  # raised by a signal's handler, anywhere: one wake-up too many is harmless
                self.work_queue.post(self)
                raise
        if self.watchers:
            self._tell()

    def _tell(self) -> None:
        for wake in self.watchers:
            wake()

    def handle(self, event: E) -> object:
        """Run the callback for `event`, which was taken; as `run` does."""
        if self._handle is not None:
            return self._handle(event)
        owner = self._object()
        return None if owner is None else self._function(owner, event)

    def take(self) -> E | None:
        """Take the oldest event out, past the callback; None if there is none."""
        try:
            return self._events.popleft()
        except IndexError:
            return None

    def close(self) -> None:
        """Discard the waiting events and refuse later ones. A running callback goes on."""
        self.closed = True
        self._events.clear()

    def run(self) -> object:
        """Run the callback for the oldest event."""
        try:
            event = self._events.popleft()
        except IndexError:
            self._go_on()
            return None
        if not self._alone:
            self._go_on()  # the callback may run beside itself: let another thread have the next event
        # hot path: `handle`, without that call.
        if self._handle is not None:
            return self._handle(event)
        owner = self._object()
        return None if owner is None else self._function(owner, event)

    def settle(self) -> None:
        if self._alone:
            self._posted = False
            if self._events:  # hot path: asked here, too, and mostly no: 0.6 us less a callback after a sleep
                self._go_on()

    def _go_on(self) -> None:
        """Post the queue again if events wait."""
        self._posted = False
        if self._events:
            self._posted = True
            try:
                self.work_queue.post(self)
            except BaseException:  # as in `deliver`
                self.work_queue.post(self)
                raise


class ResponseTicks(EventQueue[None]):
    """Answers whose futures nobody waits for: each is one callback's turn, in which nothing is left to do.

    rclpy takes an answer in a turn of the executor, so `while not future.done(): rclpy.spin_once(node)` ends.
    Here the future is done before that; the turn lets `spin_once` return. `owner` is whose turn it is.
    """

    __slots__ = ('_owner',)

    def __init__(self, work_queue: NodeWorkQueue, owner: object) -> None:
        super().__init__(work_queue, None, bool, depth=TICKS_LIMIT)
        self._owner = owner

    @property
    def entity(self) -> object:
        return self._owner


class GuardCondition(CallbackSource):
    """Triggers that come before the callback has run count as one."""

    __slots__ = ('__dict__', '_destroyed', '_posted', 'callback', 'events', 'watchers')

    counts_up = True

    def __init__(
        self,
        callback: Callable[[], object] | None,
        callback_group: CallbackGroup | None,
        context: ContextLike | None = None,  # noqa: ARG002
        *,
        work_queue: NodeWorkQueue | None = None,
    ) -> None:
        super().__init__(NodeWorkQueue() if work_queue is None else work_queue, callback_group)
        self.callback = callback
        self._posted = self._destroyed = False
        self.events = 0
        """How often it was triggered; triggers at nearly the same time may count as one. See
        waitable.Waited."""
        self.watchers: Sequence[Callable[[], None]] = ()

    @property
    def callback_group(self) -> CallbackGroup | None:
        """The group that it was made with."""
        return self.group

    @property
    def handle(self) -> GuardCondition:
        """Its handle, as rclpy's programs use it. Raises InvalidHandle once destroyed."""
        if self._destroyed:
            raise InvalidHandle
        return handle_of(self)

    def trigger(self) -> None:
        """Have the callback called soon. Any thread, signal handlers too. InvalidHandle once destroyed."""
        if self._destroyed:
            raise InvalidHandle
        self.events += 1
        if not self._posted:
            self._posted = True
            self.work_queue.post(self)
        for wake in self.watchers:
            wake()

    def destroy(self) -> None:
        """Stop triggering. Idempotent."""
        self._destroyed = True

    def run(self) -> object:
        self._posted = False
        if self._destroyed or self.callback is None:
            return None
        return self.callback()
