"""Where a node's work goes: to the executor that the node is in, or to a backlog while it is in none."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.execution.agenda import Agenda, Alarm
    from goalwire.execution.lookout import Lookout
    from goalwire.execution.ready import ReadyQueue
    from goalwire.execution.work import Work


class Home:
    """The address that all of a node's entities post to, whichever executor the node is in.

    Moving costs what is pending and the number of timers, not the number of entities: `rclpy.spin_once(node)`
    adds and removes the node with every call.
    """

    __slots__ = ('__weakref__', '_alarms', '_backlog', '_lookouts', 'agenda', 'queue')

    def __init__(self) -> None:
        self.queue: ReadyQueue | None = None
        self.agenda: Agenda | None = None
        self._backlog: deque[Work] = deque()
        self._alarms: dict[Alarm, None] = {}  # in order, so that what is due at once comes in that order
        self._lookouts: dict[Lookout, None] = {}

    @property
    def attached(self) -> bool:
        """Whether an executor runs what is posted here."""
        return self.queue is not None

    def post(self, work: Work) -> None:
        """Queue `work` for the executor. Any thread."""
        queue = self.queue
        if queue is None:
            self._backlog.append(work)
            if self.queue is not None:
                self._flush()  # attached in between
            return
        queue.items.append(work)  # as `queue.post` does: one call less for each event
        if queue.wakers:
            queue.wake_one()
        if self.queue is not queue:
            self._move_out(queue)  # detached in between

    def attach(self, queue: ReadyQueue, agenda: Agenda) -> None:
        """From now on post to `queue`, and let timers follow `agenda`."""
        if self.queue is not None:
            self.detach()
        self.agenda = agenda
        self.queue = queue
        if self._backlog:
            self._flush()
        for lookout in tuple(self._lookouts):
            queue.add_lookout(lookout)
        for alarm in tuple(self._alarms):
            due = alarm.due  # read once: another thread may ring it
            if due is not None and alarm.agenda is not agenda:
                agenda.set(alarm, due)

    def detach(self) -> None:
        """Take everything pending back from the executor. Timers keep their due times."""
        queue = self.queue
        if queue is None:
            return
        self.queue = self.agenda = None
        for lookout in tuple(self._lookouts):
            queue.drop_lookout(lookout)
        if queue.items:
            self._move_out(queue)

    def set_alarm(self, alarm: Alarm, due: int) -> None:
        """Let `alarm` ring at steady time `due` (ns), whichever executor the node is in by then."""
        self._alarms[alarm] = None
        if self.agenda is None and (left := alarm.agenda) is not None:
            left.forget(alarm)  # the executor that the node has left, and may come back to
        alarm.due = due
        agenda = self.agenda
        while agenda is not None:
            agenda.set(alarm, due)
            moved = self.agenda
            if moved is agenda:
                return
            agenda = moved

    def drop_alarm(self, alarm: Alarm) -> None:
        """Forget `alarm`."""
        self._alarms.pop(alarm, None)
        while (agenda := alarm.agenda) is not None:  # it may be moving
            agenda.forget(alarm)
        alarm.due = None

    def add_lookout(self, lookout: Lookout) -> None:
        """Let `lookout` be asked for work, by whichever executor the node is in."""
        self._lookouts[lookout] = None
        while (queue := self.queue) is not None:
            queue.add_lookout(lookout)
            if self.queue is queue:
                return
            queue.drop_lookout(lookout)  # the node has moved in between

    def drop_lookout(self, waitable: object) -> None:
        """Ask `waitable` no more; nothing where it is not asked."""
        for lookout in tuple(self._lookouts):
            if lookout.waitable is waitable:
                del self._lookouts[lookout]
                if self.queue is not None:
                    self.queue.drop_lookout(lookout)
                lookout.close()

    def _flush(self) -> None:
        while self._backlog:
            try:
                work = self._backlog.popleft()
            except IndexError:
                return
            self.post(work)

    def _move_out(self, queue: ReadyQueue) -> None:
        for work in queue.reclaim(self):
            self.post(work)
