"""The ready queue of an executor, the callback sources that are in it, and the work queue of a node."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, ref

from goalwire.execution.time.steady_clock import STEADY
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.execution.time.steady_clock import SteadyClock
    from goalwire.execution.time.timer_heap import TimerEntry, TimerHeap
    from goalwire.execution.waiters import StopCondition, Waiter

_NOTHING_MORE: Callable[[], object] = bool
# hot path: a C function that does nothing; a Python function would take 0.6 us a callback after a sleep.


class CallbackSource:
    """A source of callbacks: a subscription's event queue, a timer, a task, an asyncio runner.

    Each turn through an executor's queue runs one callback, so sources take turns fairly.
    """

    __slots__ = ('__weakref__', 'group', 'work_queue')

    is_patient = False
    """True if this source's events can well wait for the end of a callback, as a request for the result of
    the goal that the callback executes.
    """

    def __init__(self, work_queue: NodeWorkQueue, group: CallbackGroup | None) -> None:
        self.work_queue = work_queue if group is None or group.work_queue is None else group.work_queue
        self.group = group

    @property
    def entity(self) -> object:
        """The entity whose callbacks these are, for executors that users have written."""
        return self

    @property
    def backlog(self) -> int:
        """The number of waiting events of this source."""
        return 1

    def run(self) -> object:
        """Take one event and run the user's callback for it.

        If the callback is `async def`, return its coroutine: the executor runs it as an asyncio task and
        holds the group until the task ends. Other values are ignored. Spin raises the errors of this method.
        """
        raise NotImplementedError

    settle = staticmethod(_NOTHING_MORE)
    """Called when the callback has ended and the group is free. A source with more work posts
    itself again.
    """


class CallbackGroup:
    """A group of entities. Its rule says which of their callbacks may run at the same time."""

    exclusive = False
    """True if only one callback at a time may run."""

    foreign = False
    """True if a program has written the rule, in a subclass."""

    is_default = False
    """True for a node's default group, which has the callbacks for which the program chose no group."""

    work_queue: NodeWorkQueue | None = None
    """The queue for the work of the members; None: their node's queue. To be set before the members
    are made.
    """

    def __init__(self) -> None:
        self.entities: WeakMembers[object] = WeakMembers()
        self._active: object = None

    def __init_subclass__(cls) -> None:
        if 'begin' not in vars(cls) and _RULE & vars(cls).keys():
            cls.foreign = True
            cls.begin = CallbackGroup.begin  # type: ignore[method-assign]  # if a quicker one was inherited
            cls.ended = CallbackGroup.ended  # type: ignore[method-assign]

    def add_entity(self, entity: object) -> None:
        """Make `entity` a member. Raises TypeError for an object without weak references."""
        self.entities.add(entity)

    def has_entity(self, entity: object) -> bool:
        """Tell whether `entity` is a member."""
        return ref(entity) in self.entities

    def can_execute(self, entity: object) -> bool:
        """Tell whether a callback of `entity` may start now."""
        raise NotImplementedError

    def beginning_execution(self, entity: object) -> bool:
        """Note that a callback of `entity` starts; False if it may not."""
        raise NotImplementedError

    def ending_execution(self, entity: object) -> None:
        """Note that a callback of `entity` has ended."""
        raise NotImplementedError

    def begin(self, source: CallbackSource, /) -> bool:
        """Note that a callback of `source` starts; False if the rule does not allow that now."""
        entity = source.entity
        return self.can_execute(entity) and self.beginning_execution(entity)

    def ended(self, source: CallbackSource, /) -> None:
        """Note that a callback of `source` has ended."""
        self.ending_execution(source.entity)

    @property
    def active_entity(self) -> object:
        """The entity whose callback runs in an exclusive group, or None."""
        return self._active

    @property
    def parked(self) -> Sequence[CallbackSource]:
        """The sources that wait for the running callback to end."""
        return ()

    def park(self, source: CallbackSource) -> None:
        """Keep `source`, which may not start now, and post it again when it may."""
        raise NotImplementedError


_RULE = {'can_execute', 'beginning_execution', 'ending_execution'}
"""The methods of the rule. A group whose class overrides one of them is `foreign`."""


class Poller(Protocol):
    """An object that an executor asks for work each time before it takes work: see `WaitablePoller`."""

    @property
    def waitable(self) -> object:
        """The waitable that the poller asks."""

    def look(self) -> None:
        """Ask the poller, and post the work that it has."""

    def close(self) -> None:
        """Stop asking the waitable."""


class Driver(Protocol):
    """The executor that runs the work of a queue."""

    def is_driven(self) -> bool:
        """Tell whether a thread spins the executor."""


def _nobody() -> None:
    """Return None, for a queue without an executor."""


class ReadyQueue:
    """A first-in-first-out queue. It takes no lock: each step is one atomic operation of a deque or a list.

    No wake-up is lost, because both sides act in opposite order. A poster appends its work, then looks for
    sleepers. A sleeper puts itself on the list, then looks for work. One of them sees the other. The thread
    that went to sleep last is woken first: its caches are warm, and the others sleep on.
    """

    __slots__ = ('_recheck_wanted', 'closed', 'driver', 'items', 'pollers', 'wakers')

    def __init__(self, driver: Callable[[], Driver | None] = _nobody) -> None:
        self.driver = driver
        """Returns the executor that runs the work of this queue. It is a weak reference, since the wire
        holds the queue."""
        self.items: deque[CallbackSource] = deque()
        self.pollers: WeakMembers[Poller] = WeakMembers()
        """The pollers, which are asked before any work is taken. Their nodes own them."""
        self.wakers: list[Callable[[], None]] = []
        """The wake functions of the sleeping threads, the last to fall asleep at the end."""
        self.closed = False
        """True once no thread may sleep here."""
        self._recheck_wanted = False

    def post(self, source: CallbackSource) -> None:
        """Append `source`, then wake one sleeper, if any. Callable from any thread."""
        self.items.append(source)
        if self.wakers:
            self.wake_one()

    def pop(self) -> CallbackSource | None:
        """Take the oldest ready work out and return it; None if there is none."""
        try:
            return self.items.popleft()
        except IndexError:
            return None

    def take(self, source: CallbackSource) -> bool:
        """Take `source` out of turn; False if it is not here."""
        try:
            self.items.remove(source)
        except ValueError:
            return False
        return True

    def recheck(self) -> None:
        """Have a sleeping thread ask the pollers again; if none sleeps, the next thread that is about to
        sleep. Callable from any thread.
        """
        self._recheck_wanted = True
        self.wake_one()

    def add_poller(self, poller: Poller) -> None:
        """Have `poller` asked for work from now on. Adding it twice is harmless."""
        self.pollers.add(poller)
        self.recheck()

    def remove_poller(self, poller: Poller) -> None:
        """Stop asking `poller` for work. Does nothing if it was not added."""
        self.pollers.discard(poller)

    def poll_waitables(self) -> None:
        """Ask all pollers; those with work post it here."""
        self._recheck_wanted = False
        for poller in self.pollers.alive():
            poller.look()

    @property
    def has_work(self) -> bool:
        """True if a thread must look here again before it sleeps."""
        return bool(self.items) or (self._recheck_wanted and bool(self.pollers))

    def wake_one(self) -> None:
        """Wake one sleeper, which looks again. A thread that leaves while there is work must call this."""
        if not self.wakers:  # timers often call this, and this look is cheaper than an IndexError
            return
        try:
            waker = self.wakers.pop()
        except IndexError:
            return
        waker()

    def wake_all(self) -> None:
        """Wake all sleepers, so that they look again."""
        while self.wakers:
            self.wake_one()

    def listen(self, waker: Callable[[], None]) -> None:
        """Have `waker` called once when there may be work, at once if there is. An asyncio loop waits for
        work by this method.
        """
        self.wakers.append(waker)
        if self.has_work:
            self.wake_one()

    def unlisten(self, waker: Callable[[], None]) -> None:
        """Remove a waker, if it has not been called."""
        try:
            self.wakers.remove(waker)
        except ValueError:
            return  # contextlib.suppress would take three more calls at each sleep

    @property
    def sleepers(self) -> int:
        """The number of threads that sleep here."""
        return len(self.wakers)

    def park(
        self,
        waiter: Waiter,
        clock: SteadyClock,
        stop: StopCondition,
        deadline: int | None,
        timer_heap: TimerHeap | None = None,
        *,
        last: bool = False,
    ) -> None:
        """Sleep in `waiter` until there may be work, `stop`, `deadline` (ns), or the next timer.

        `last` makes this sleeper the last one to be woken by posts.
        """
        wakers, wake = self.wakers, waiter.wake
        try:
            if last:
                wakers.insert(0, wake)
            else:
                wakers.append(wake)
            # The looks come after the append. A thread that posts work or sets a timer acts in opposite
            # order: it changes the queue or the heap, then looks at `wakers`. So one of the two sees the
            # other.
            if timer_heap is not None:
                due = timer_heap.earliest
                if due is not None and (deadline is None or due < deadline):
                    deadline = due
            if self.items or (self._recheck_wanted and self.pollers) or self.closed or stop.completion_state:
                return
            # hot path: the bodies of `STEADY.wait` and `unlisten`, since their calls would take 1.2 us a
            # sleep.
            if clock is STEADY:
                waiter.wait(None if deadline is None else deadline - clock.now())
            else:
                clock.wait(waiter, deadline)
        finally:
            # If a poster has taken `wake`, it calls it, and the next wait of `waiter` may end at once. That
            # is harmless: the thread looks again.
            if wakers:
                try:  # noqa: SIM105
                    wakers.remove(wake)
                except ValueError:
                    pass

    def reclaim(self, work_queue: NodeWorkQueue) -> list[CallbackSource]:
        """Take out all work of `work_queue`, oldest first. The rest keeps its order."""
        taken = []
        for _ in range(len(self.items)):
            source = self.pop()
            if source is None:
                break
            if source.work_queue is work_queue:
                taken.append(source)
            else:
                self.items.append(source)
        if self.items:
            self.wake_one()
        return taken


class Home:
    """A record of the executor that a node was in last. It may outlive the node."""

    __slots__ = ('driver',)

    def __init__(self) -> None:
        self.driver: Callable[[], Driver | None] | None = None
        """A function that returns the executor, or None after its end; None if the node was in
        no executor.
        """


class NodeWorkQueue:
    """The queue to which all entities of a node post. It passes the work on to the executor of the node.

    So a node moves to another executor in a time that depends on its pending work and its timers, not on the
    number of its entities. That matters, since each `rclpy.spin_once(node)` adds and removes the node.
    """

    __slots__ = ('__weakref__', '_backlog', '_pollers', '_timer_entries', 'home', 'queue', 'timer_heap')

    def __init__(self) -> None:
        self.home = Home()
        self.queue: ReadyQueue | None = None
        self.timer_heap: TimerHeap | None = None
        self._backlog: deque[CallbackSource] = deque()
        self._timer_entries: dict[ReferenceType[TimerEntry], None] = {}
        """The entries in the order of setting, which is also the order of calls that are due at the same
        time. The references are weak, since the wire refers to this queue.
        """
        self._pollers: dict[Poller, None] = {}

    @property
    def attached(self) -> bool:
        """True if an executor runs the work of this node."""
        return self.queue is not None

    def executor(self) -> object:
        """Return the executor that runs the work of this node, or ran it last; None if there is none."""
        driver = self.home.driver
        return None if driver is None else driver()

    def post(self, source: CallbackSource) -> None:
        """Queue `source` for the executor. Callable from any thread."""
        queue = self.queue
        if queue is None:
            self._backlog.append(source)
            if self.queue is not None:
                self._flush()  # another thread has attached a queue meanwhile
            return
        # hot path: the body of `queue.post`, since its call would take 0.6 us for each event.
        queue.items.append(source)
        if queue.wakers:
            queue.wake_one()
        if self.queue is not queue:
            self._move_out(queue)  # another thread has detached the queue

    def post_first(self, source: CallbackSource) -> None:
        """Queue `source` for the executor before all that waits there. Callable from any thread."""
        queue = self.queue
        if queue is None:
            self.post(source)  # the next executor takes the waiting work in the order of posting
            return
        queue.items.appendleft(source)
        if queue.wakers:
            queue.wake_one()
        if self.queue is not queue:
            self._move_out(queue)  # another thread has detached the queue

    def waits(self, due: int) -> bool:
        """Tell whether work waits here without an executor, or a timer has been due since
        `due` (steady ns).
        """
        entries = [reference() for reference in list(self._timer_entries)]
        return bool(self._backlog) or any(
            entry is not None and entry.due is not None and entry.due < due for entry in entries
        )

    def attach(self, queue: ReadyQueue, timer_heap: TimerHeap) -> None:
        """From now on post to `queue`, and let timers follow `timer_heap`."""
        # `queue` is set before the backlog is flushed. `post` appends to the backlog, then looks at `queue`.
        # So work that is posted meanwhile is flushed by one of the two.
        if self.queue is not None:
            self.detach()
        self.home.driver = queue.driver
        self.timer_heap = timer_heap
        self.queue = queue
        if self._backlog:
            self._flush()
        for poller in list(self._pollers):
            queue.add_poller(poller)
        for reference in list(self._timer_entries):
            entry = reference()
            if entry is None:
                self._timer_entries.pop(reference, None)
                continue
            due = entry.due  # read once: another thread may call the entry, which resets `due`
            if due is not None and entry.timer_heap is not timer_heap:
                timer_heap.set(entry, due)

    def detach(self) -> None:
        """Take all pending work back from the executor. Timers keep their due times."""
        # `queue` is reset before the work is moved out. `post` appends to the queue, then looks whether it is
        # still the node's queue. So work that is posted meanwhile is moved out by one of the two.
        queue = self.queue
        if queue is None:
            return
        self.queue = self.timer_heap = None
        for poller in list(self._pollers):
            queue.remove_poller(poller)
        if queue.items:
            self._move_out(queue)

    def set_timer_entry(self, entry: TimerEntry, due: int) -> None:
        """Have `entry` called at steady time `due` (ns), by the executor that the node is in by then.

        The loop is needed because the node may move meanwhile: it ends if the node's heap is still the one in
        which the entry was set.
        """
        self._timer_entries[entry.reference] = None
        if self.timer_heap is None and (left := entry.timer_heap) is not None:
            left.discard(entry)  # the heap of the executor that the node has left, perhaps for a time
        entry.due = due
        timer_heap = self.timer_heap
        while timer_heap is not None:
            timer_heap.set(entry, due)
            moved = self.timer_heap
            if moved is timer_heap:
                return
            timer_heap = moved

    def discard_timer_entry(self, entry: TimerEntry) -> None:
        """Forget `entry`."""
        self._timer_entries.pop(entry.reference, None)
        while (timer_heap := entry.timer_heap) is not None:  # the node may be moving to another executor
            timer_heap.discard(entry)
        entry.due = None

    def add_poller(self, poller: Poller) -> None:
        """Have `poller` asked for work by each executor that the node is in."""
        self._pollers[poller] = None
        while (queue := self.queue) is not None:
            queue.add_poller(poller)
            if self.queue is queue:
                return
            queue.remove_poller(poller)  # the node has moved meanwhile: try its new queue

    def remove_poller(self, waitable: object) -> None:
        """Stop asking `waitable` for work. Does nothing if it was not added."""
        for poller in list(self._pollers):
            if poller.waitable is waitable:
                del self._pollers[poller]
                if self.queue is not None:
                    self.queue.remove_poller(poller)
                poller.close()

    def _flush(self) -> None:
        while self._backlog:
            try:
                source = self._backlog.popleft()
            except IndexError:
                return
            self.post(source)

    def _move_out(self, queue: ReadyQueue) -> None:
        for source in queue.reclaim(self):
            self.post(source)
