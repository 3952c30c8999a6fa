"""Sources of callbacks: the event queue of a subscription, service or client, the guard condition, a call."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.errors import InvalidHandle
from goalwire.execution.rclpy_handle import handle_of
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue
from goalwire.execution.weak_methods import weak_parts

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.shutdown_signal import ContextLike

E = TypeVar('E')

TICKS_LIMIT = 1000
"""The largest number of empty turns that one client keeps for later spins. In a program that never spins,
they would pile up.
"""


class EventQueue(CallbackSource, Generic[E]):
    """Events that wait for their callback, `depth` of them at most (None: without limit).

    If the queue is full, the oldest event is dropped. With `refuse` the new event goes to `refuse` instead.
    `dropped` counts both. The executor's ready queue holds this queue at most once, for any number of events.
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
        'is_patient',
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
        """Make a queue. `refuse` also gets the events that come after `close`, on the delivering thread."""
        super().__init__(work_queue, group)
        self.depth = depth
        self.dropped = 0
        self.closed = False
        self.is_patient = False
        self.note: Callable[[E], object] | None = None
        """A function that is called with each event before the event is queued."""
        self.watchers: Sequence[Callable[[], None]] = ()
        # A bound method is held weakly: the wire refers to this queue, and must not keep the entity alive.
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
        """The number of waiting events; see waitable.Waited."""
        return len(self._events)

    def deliver(self, event: E) -> None:
        """Queue `event`. A transport calls this for each event, on any thread. It is short and takes no lock.

        No event is forgotten, because both sides act in opposite order. `deliver` appends the event, then
        looks at `_posted`. `_go_on` resets `_posted`, then looks for events.
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
            except BaseException:  # a signal handler has raised, perhaps before the post: post again
                self.work_queue.post(self)
                raise
        if self.watchers:
            self._tell()

    def _tell(self) -> None:
        for wake in self.watchers:
            wake()

    def handle(self, event: E) -> object:
        """Run the callback for `event`, which was taken out before, and return what it returns."""
        if self._handle is not None:
            return self._handle(event)
        owner = self._object()
        return None if owner is None else self._function(owner, event)

    def take(self) -> E | None:
        """Take the oldest event out without running the callback; None if there is none."""
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
            self._go_on()  # the group is reentrant: another thread may run the next event at the same time
        # hot path: the body of `handle`, which saves its call.
        if self._handle is not None:
            return self._handle(event)
        owner = self._object()
        return None if owner is None else self._function(owner, event)

    def settle(self) -> None:
        if self._alone:
            self._posted = False
            if self._events:  # hot path: mostly False, which saves a call (0.6 us a callback)
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
    """Empty turns of the executor, one for each response whose future nobody waited for.

    rclpy handles a response in a turn of the executor, so `spin_once` returns after it. Here the wire
    completes the future before any turn. The empty turn lets `spin_once` return as in rclpy, so that a loop
    such as `while not future.done(): rclpy.spin_once(node)` ends. `owner` is the client.
    """

    __slots__ = ('_owner',)

    def __init__(self, work_queue: NodeWorkQueue, owner: object) -> None:
        super().__init__(work_queue, None, bool, depth=TICKS_LIMIT)
        self._owner = owner

    @property
    def entity(self) -> object:
        return self._owner


class GuardCondition(CallbackSource):
    """Has its callback called after `trigger`. Triggers that come before the callback has run
    count as one.
    """

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
        """The number of triggers; triggers at nearly the same time may count as one. See waitable.Waited."""
        self.watchers: Sequence[Callable[[], None]] = ()

    @property
    def callback_group(self) -> CallbackGroup | None:
        """The callback group that was passed to the constructor."""
        return self.group

    @property
    def handle(self) -> GuardCondition:
        """The guard condition's handle, as programs of rclpy use it. Raises InvalidHandle once destroyed."""
        if self._destroyed:
            raise InvalidHandle
        return handle_of(self)

    def trigger(self) -> None:
        """Have the callback called soon. Callable from any thread and from signal handlers. Raises
        InvalidHandle once destroyed.
        """
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


class CallSoon(CallbackSource):
    """A function to be called once on a thread of the executor, in no callback group. Posting this object
    requests the call.
    """

    __slots__ = ('_call',)

    def __init__(self, work_queue: NodeWorkQueue, call: Callable[[], object]) -> None:
        super().__init__(work_queue, None)
        self._call = call

    def run(self) -> None:
        self._call()
