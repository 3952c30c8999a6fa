"""Where a node's work goes: to the executor that the node is in, or to a backlog while it is in none."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.execution.callback_source import CallbackSource
    from goalwire.execution.ready import ReadyQueue
    from goalwire.execution.timer_heap import TimerEntry, TimerHeap
    from goalwire.execution.waitable_poller import WaitablePoller


class NodeWorkQueue:
    """The address that all of a node's entities post to, whichever executor the node is in.

    Moving costs what is pending and the number of timers, not the number of entities: `rclpy.spin_once(node)`
    adds and removes the node with every call.
    """

    __slots__ = ('__weakref__', '_alarms', '_backlog', '_pollers', 'queue', 'timer_heap')

    def __init__(self) -> None:
        self.queue: ReadyQueue | None = None
        self.timer_heap: TimerHeap | None = None
        self._backlog: deque[CallbackSource] = deque()
        self._alarms: dict[TimerEntry, None] = {}  # in order, so that what is due at once comes in that order
        self._pollers: dict[WaitablePoller, None] = {}

    @property
    def attached(self) -> bool:
        """Whether an executor runs what is posted here."""
        return self.queue is not None

    def post(self, source: CallbackSource) -> None:
        """Queue `work` for the executor. Any thread."""
        queue = self.queue
        if queue is None:
            self._backlog.append(source)
            if self.queue is not None:
                self._flush()  # attached in between
            return
        queue.items.append(source)  # as `queue.post` does: one call less for each event
        if queue.wakers:
            queue.wake_one()
        if self.queue is not queue:
            self._move_out(queue)  # detached in between

    def attach(self, queue: ReadyQueue, timer_heap: TimerHeap) -> None:
        """From now on post to `queue`, and let timers follow `timer_heap`."""
        if self.queue is not None:
            self.detach()
        self.timer_heap = timer_heap
        self.queue = queue
        if self._backlog:
            self._flush()
        for poller in tuple(self._pollers):
            queue.add_poller(poller)
        for alarm in tuple(self._alarms):
            due = alarm.due  # read once: another thread may ring it
            if due is not None and alarm.timer_heap is not timer_heap:
                timer_heap.set(alarm, due)

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

    def set_alarm(self, alarm: TimerEntry, due: int) -> None:
        """Let `alarm` ring at steady time `due` (ns), whichever executor the node is in by then."""
        self._alarms[alarm] = None
        if self.timer_heap is None and (left := alarm.timer_heap) is not None:
            left.forget(alarm)  # the executor that the node has left, and may come back to
        alarm.due = due
        timer_heap = self.timer_heap
        while timer_heap is not None:
            timer_heap.set(alarm, due)
            moved = self.timer_heap
            if moved is timer_heap:
                return
            timer_heap = moved

    def drop_alarm(self, alarm: TimerEntry) -> None:
        """Forget `alarm`."""
        self._alarms.pop(alarm, None)
        while (timer_heap := alarm.timer_heap) is not None:  # it may be moving
            timer_heap.forget(alarm)
        alarm.due = None

    def add_poller(self, poller: WaitablePoller) -> None:
        """Let `poller` be asked for work, by whichever executor the node is in."""
        self._pollers[poller] = None
        while (queue := self.queue) is not None:
            queue.add_poller(poller)
            if self.queue is queue:
                return
            queue.remove_poller(poller)  # the node has moved in between

    def remove_poller(self, waitable: object) -> None:
        """Ask `waitable` no more; nothing where it is not asked."""
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
