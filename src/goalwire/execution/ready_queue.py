"""The ready queue of an executor, the callback sources that are in it, and the work queue of a node."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, WeakSet

from goalwire.execution.monotonic import STEADY
from goalwire.execution.waiting import WeakListeners

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.execution.monotonic import SteadyClock
    from goalwire.execution.timer_heap import TimerEntry, TimerHeap
    from goalwire.execution.waiting import StopCondition, Waiter

_NOTHING_MORE: Callable[[], object] = bool
# hot path: does nothing, and enters no function of Python's for it: 0.6 us less a callback after a sleep.


class CallbackSource:
    """A source of callbacks: a subscription's event queue, a timer, a task, an asyncio runner.

    Each turn through an executor's queue runs one callback, so sources take turns fairly.
    """

    __slots__ = ('__weakref__', 'group', 'work_queue')

    def __init__(self, work_queue: NodeWorkQueue, group: CallbackGroup | None) -> None:
        self.work_queue = work_queue if group is None or group.work_queue is None else group.work_queue
        self.group = group

    @property
    def entity(self) -> object:
        """The entity whose callbacks these are, for executors that users have written."""
        return self

    @property
    def backlog(self) -> int:
        """How many events of this source wait."""
        return 1

    def run(self) -> object:
        """Take one event and run the user's callback for it.

        Where the callback is `async def`, return the coroutine it made: the executor runs it as an asyncio
        task and holds the group until that ends. Any other value means nothing. What this raises comes out
        of spin.
        """
        raise NotImplementedError

    settle = staticmethod(_NOTHING_MORE)
    """Called when the callback has ended and the group is free: post again if there is more to do."""


class CallSoon(CallbackSource):
    """One call on the executor's thread, in no callback group; `work_queue.post` brings it there."""

    __slots__ = ('_call',)

    def __init__(self, work_queue: NodeWorkQueue, call: Callable[[], object]) -> None:
        super().__init__(work_queue, None)
        self._call = call

    def run(self) -> None:
        self._call()


class CallbackGroup:
    """The entities whose callbacks one rule governs."""

    exclusive = False
    """Whether one callback at a time may run."""

    foreign = False
    """Whether a program has written its rule."""

    is_default = False
    """Whether a node gives it to callbacks for which the program chose none."""

    work_queue: NodeWorkQueue | None = None
    """Where its members' work goes, if not to their node's executor; to be set before they are made."""

    def __init__(self) -> None:
        self.entities: WeakSet[object] = WeakSet()
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
        """Whether `entity` is a member."""
        return entity in self.entities

    def can_execute(self, entity: object) -> bool:
        """Whether a callback of `entity` may start now."""
        raise NotImplementedError

    def beginning_execution(self, entity: object) -> bool:
        """Note that a callback of `entity` starts; False if it may not."""
        raise NotImplementedError

    def ending_execution(self, entity: object) -> None:
        """Note that a callback of `entity` has ended."""
        raise NotImplementedError

    def begin(self, source: CallbackSource, /) -> bool:
        """Ask the rule whether a callback of `source` may start, and note that it does."""
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
"""The methods that a program's own group overrides."""


class Poller(Protocol):
    """An executor asks it for work each time before it takes some: see `WaitablePoller`."""

    @property
    def waitable(self) -> object:
        """The waitable that it asks."""

    def look(self) -> None:
        """Ask the poller, and post the work that it has."""

    def close(self) -> None:
        """Stop asking the waitable."""


class Driver(Protocol):
    """The executor that runs the work of a queue."""

    def is_driven(self) -> bool:
        """Whether a thread spins the executor."""


def _nobody() -> None:
    """Stand for the executor of a queue that has none."""


class ReadyQueue:
    """First in, first out. It takes no lock: each step is one atomic operation of a deque or a list.

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
        self.pollers: WeakListeners[Poller] = WeakListeners()
        """The pollers, which are asked before any work is taken. Their nodes own them."""
        self.wakers: list[Callable[[], None]] = []
        """The wake functions of the sleeping threads, the last to fall asleep at the end."""
        self.closed = False
        """True once no thread may sleep here."""
        self._recheck_wanted = False

    def post(self, source: CallbackSource) -> None:
        """Append `source` and wake one sleeper, if any: the poster's last act. Any thread."""
        self.items.append(source)
        if self.wakers:
            self.wake_one()

    def pop(self) -> CallbackSource | None:
        """The oldest ready work, or None."""
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
        """Have a sleeper ask the pollers once more, or the next thread that is about to sleep. Any thread."""
        self._recheck_wanted = True
        self.wake_one()

    def add_poller(self, poller: Poller) -> None:
        """Ask `poller` from now on. Adding twice is harmless."""
        self.pollers.add(poller)
        self.recheck()

    def remove_poller(self, poller: Poller) -> None:
        """Stop asking `poller`; nothing if it is not asked."""
        self.pollers.discard(poller)

    def poll_waitables(self) -> None:
        """Have the pollers look; those with work post it here."""
        self._recheck_wanted = False
        for poller in self.pollers.alive():
            poller.look()

    @property
    def has_work(self) -> bool:
        """Whether there is something to do before anybody sleeps."""
        return bool(self.items) or (self._recheck_wanted and bool(self.pollers))

    def wake_one(self) -> None:
        """Let one sleeper look again. A thread that leaves while there is work must call this."""
        if not self.wakers:  # each tick of a timer comes here, and an exception costs more than this look
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
        """Call `waker` once when there may be work, at once if there is: how a loop sleeps here."""
        self.wakers.append(waker)
        if self.has_work:
            self.wake_one()

    def unlisten(self, waker: Callable[[], None]) -> None:
        """Take a waker back, if it has not been called."""
        try:
            self.wakers.remove(waker)
        except ValueError:
            return  # `suppress` would cost three calls more, with each sleep

    @property
    def sleepers(self) -> int:
        """How many threads sleep here."""
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
            # The looks come last. A poster, or an earlier timer's setter, acts first and then looks here.
            if timer_heap is not None:
                due = timer_heap.earliest
                if due is not None and (deadline is None or due < deadline):
                    deadline = due
            if self.items or (self._recheck_wanted and self.pollers) or self.closed or stop.completion_state:
                return
            # hot path: the bodies of `STEADY.wait` and `unlisten`, which saves their calls: 1.2 us less with
            # each sleep.
            if clock is STEADY:
                waiter.wait(None if deadline is None else deadline - clock.now())
            else:
                clock.wait(waiter, deadline)
        finally:
            # Where a poster took it: its wake-up ends this wait, or makes the next one look once more.
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
    """Which executor had a node last. It may outlive the node."""

    __slots__ = ('driver',)

    def __init__(self) -> None:
        self.driver: Callable[[], Driver | None] | None = None
        """Returns that executor, None once it is gone; None if there never was one."""


class NodeWorkQueue:
    """The address that all of a node's entities post to, whichever executor the node is in.

    Moving costs what is pending and the number of timers, not the number of entities: `rclpy.spin_once(node)`
    adds and removes the node with every call.
    """

    __slots__ = ('__weakref__', '_backlog', '_pollers', '_timer_entries', 'home', 'queue', 'timer_heap')

    def __init__(self) -> None:
        self.home = Home()
        self.queue: ReadyQueue | None = None
        self.timer_heap: TimerHeap | None = None
        self._backlog: deque[CallbackSource] = deque()
        self._timer_entries: dict[ReferenceType[TimerEntry], None] = {}
        """In the order of setting, which entries that are due at once keep. Weak references: the wire
        holds this."""
        self._pollers: dict[Poller, None] = {}

    @property
    def attached(self) -> bool:
        """Whether an executor runs the work of this node."""
        return self.queue is not None

    def post(self, source: CallbackSource) -> None:
        """Queue `source` for the executor. Any thread."""
        queue = self.queue
        if queue is None:
            self._backlog.append(source)
            if self.queue is not None:
                self._flush()  # attached by another thread meanwhile
            return
        # hot path: `queue.post`, without that call: 0.6 us less for each event that wakes a thread.
        queue.items.append(source)
        if queue.wakers:
            queue.wake_one()
        if self.queue is not queue:
            self._move_out(queue)  # detached by another thread meanwhile

    def post_first(self, source: CallbackSource) -> None:
        """Queue `source` for the executor before all that waits there. Any thread."""
        queue = self.queue
        if queue is None:
            self.post(source)  # the executor that comes takes all that waits in its order
            return
        queue.items.appendleft(source)
        if queue.wakers:
            queue.wake_one()
        if self.queue is not queue:
            self._move_out(queue)  # detached by another thread meanwhile

    def waits(self, due: int) -> bool:
        """Whether messages wait here without an executor, or a timer has been due since `due` (steady ns)."""
        entries = [reference() for reference in list(self._timer_entries)]
        return bool(self._backlog) or any(
            entry is not None and entry.due is not None and entry.due < due for entry in entries
        )

    def attach(self, queue: ReadyQueue, timer_heap: TimerHeap) -> None:
        """From now on post to `queue`, and let timers follow `timer_heap`."""
        if self.queue is not None:
            self.detach()
        self.home.driver = queue.driver
        self.timer_heap = timer_heap
        self.queue = queue
        if self._backlog:
            self._flush()
        for poller in tuple(self._pollers):
            queue.add_poller(poller)
        for reference in tuple(self._timer_entries):
            entry = reference()
            if entry is None:
                self._timer_entries.pop(reference, None)
                continue
            due = entry.due  # read once: another thread may call it
            if due is not None and entry.timer_heap is not timer_heap:
                timer_heap.set(entry, due)

    def detach(self) -> None:
        """Take everything pending back from the executor. Timers keep their due times."""
        queue = self.queue
        if queue is None:
            return
        self.queue = self.timer_heap = None
        for poller in tuple(self._pollers):
            queue.remove_poller(poller)
        if queue.items:
            self._move_out(queue)

    def set_timer_entry(self, entry: TimerEntry, due: int) -> None:
        """Call `entry` at steady time `due` (ns), whichever executor the node is in by then."""
        self._timer_entries[entry.reference] = None
        if self.timer_heap is None and (left := entry.timer_heap) is not None:
            left.discard(entry)  # the executor that the node has left, and may come back to
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
        """Let `poller` be asked for work, by whichever executor the node is in."""
        self._pollers[poller] = None
        while (queue := self.queue) is not None:
            queue.add_poller(poller)
            if self.queue is queue:
                return
            queue.remove_poller(poller)  # the node has moved in between

    def remove_poller(self, waitable: object) -> None:
        """Stop asking `waitable`; nothing if it is not asked."""
        for poller in tuple(self._pollers):
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
