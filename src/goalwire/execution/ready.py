"""The queue of ready work, and the list of threads that sleep until there is some."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING
from weakref import ReferenceType, ref

from goalwire.execution.monotonic import STEADY

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.callback_source import CallbackSource
    from goalwire.execution.monotonic import SteadyClock
    from goalwire.execution.node_work_queue import NodeWorkQueue
    from goalwire.execution.spinning import StopCondition
    from goalwire.execution.timer_heap import TimerHeap
    from goalwire.execution.waitable_poller import WaitablePoller
    from goalwire.execution.waiting import Waiter


class ReadyQueue:
    """First in, first out. It takes no lock: each step is one atomic operation of a deque or a list.

    No wake-up is lost, because both sides act in opposite order. A poster appends its work, then looks for
    sleepers. A sleeper puts itself on the list, then looks for work. One of them sees the other. The thread
    that went to sleep last is woken first: its caches are warm, and the others sleep on.
    """

    __slots__ = ('_recheck_wanted', 'closed', 'is_driven', 'items', 'pollers', 'wakers')

    def __init__(self, is_driven: Callable[[], bool] = bool) -> None:
        self.is_driven = is_driven
        """Tells whether somebody runs what is posted here."""
        self.items: deque[CallbackSource] = deque()
        self.pollers: dict[ReferenceType[WaitablePoller], None] = {}
        """Who is to be asked for work before any is taken; they belong to their nodes."""
        self.wakers: list[Callable[[], None]] = []
        """What wakes those that sleep here; who went to sleep last stands last."""
        self.closed = False
        """Whether nobody sleeps here any more."""
        self._recheck_wanted = False

    def post(self, source: CallbackSource) -> None:
        """Append `work` and wake one sleeper, if any: the poster's last act. Any thread."""
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
        """Take `work` out of turn; False where it is not here."""
        try:
            self.items.remove(source)
        except ValueError:
            return False
        return True

    def recheck(self) -> None:
        """Let the lookouts be asked once more: by a sleeper, or by who is about to sleep. Any thread."""
        self._recheck_wanted = True
        self.wake_one()

    def add_poller(self, poller: WaitablePoller) -> None:
        """Ask `poller` from now on. Adding twice is harmless."""
        self.pollers[ref(poller, self._forget)] = None
        self.recheck()

    def remove_poller(self, poller: WaitablePoller) -> None:
        """Ask `poller` no more; nothing where it is not asked."""
        self._forget(ref(poller))

    def _forget(self, reference: ReferenceType[WaitablePoller]) -> None:
        self.pollers.pop(reference, None)

    def poll_waitables(self) -> None:
        """Ask the lookouts; those with work post it here."""
        self._recheck_wanted = False
        for reference in list(self.pollers):  # no tuple: see ShutdownSignal._tell
            poller = reference()
            if poller is not None:
                poller.look()

    @property
    def has_work(self) -> bool:
        """Whether there is something to do before anybody sleeps."""
        return bool(self.items) or (self._recheck_wanted and bool(self.pollers))

    def wake_one(self) -> None:
        """Let one sleeper look again. Whoever leaves while there is work must call this."""
        if not self.wakers:  # each tick of a timer asks, and an exception costs more than a look
            return
        try:
            waker = self.wakers.pop()
        except IndexError:
            return
        waker()

    def wake_all(self) -> None:
        """Let all sleepers look again."""
        while self.wakers:
            self.wake_one()

    def listen(self, waker: Callable[[], None]) -> None:
        """Call `waker` once when there may be work, at once where there is: how a loop sleeps here."""
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
        """Sleep in `waiter` until there may be work, `ending`, `deadline` (ns), or the next timer.

        `last` makes this sleeper the last one to be woken by posts.
        """
        wakers, wake = self.wakers, waiter.wake
        try:
            if last:
                wakers.insert(0, wake)
            else:
                wakers.append(wake)
            # The looks come last: who posts, or sets an earlier alarm, does that first and then looks here.
            if timer_heap is not None:
                due = timer_heap.earliest
                if due is not None and (deadline is None or due < deadline):
                    deadline = due
            if self.items or (self._recheck_wanted and self.pollers) or self.closed or stop._state:  # noqa: SLF001
                return
            if clock is STEADY:  # its `wait` does this
                waiter.wait(None if deadline is None else deadline - clock.now())
            else:
                clock.wait(waiter, deadline)
        finally:
            # Where a poster took it: its wake-up ends this wait, or makes the next one look once more.
            if wakers:
                try:  # noqa: SIM105 - as in `unlisten`, which would be a call more
                    wakers.remove(wake)
                except ValueError:
                    pass

    def reclaim(self, work_queue: NodeWorkQueue) -> list[CallbackSource]:
        """Take out all work of `work_queue`, oldest first; the order of the rest stays."""
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
