"""How a waitable of the program's own comes to run: it is asked when its executor looks for work."""

from __future__ import annotations

from _thread import allocate_lock
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from goalwire.errors import InvalidHandle
from goalwire.execution.callback_source import CallbackSource
from goalwire.execution.clock_timer_entry import ClockTimerEntry
from goalwire.execution.wait_set import WaitSet

if TYPE_CHECKING:
    from goalwire.execution.node_work_queue import NodeWorkQueue
    from goalwire.execution.timer import Timer
    from goalwire.execution.waitable import Waitable


class WaitablePoller(CallbackSource):
    """Asks one waitable whether it is ready, each time before the executor takes work or goes to sleep.

    One thread at a time asks; a thread that finds another one at it leaves a note, so that it asks again.
    What the waitable raises while it is asked comes out of spin, like what it raises while it runs.
    """

    __slots__ = ('_alarms', '_asking', '_closed', '_error', '_found', '_missed', '_wait_set', 'waitable')

    def __init__(self, work_queue: NodeWorkQueue, waitable: Waitable[Any]) -> None:
        super().__init__(work_queue, waitable.callback_group)
        self.waitable = waitable
        self._wait_set = WaitSet(self.wake)
        self._alarms: dict[Timer, ClockTimerEntry] = {}
        self._asking = allocate_lock()
        self._missed = self._found = self._closed = False
        self._error: BaseException | None = None

    @property
    def entity(self) -> object:
        """The waitable."""
        return self.waitable

    def wake(self) -> None:
        """Get the executor to look. Any thread."""
        queue = self.work_queue.queue
        if queue is not None:
            queue.recheck()

    def look(self) -> None:
        """Ask, and post this where the answer is yes; nothing while it is posted or its group is busy."""
        self._missed = True
        while self._missed:
            if not self._asking.acquire(blocking=False):
                if self._asking.locked():
                    return  # that thread reads the note
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
        for future in waitable._futures:  # noqa: SLF001
            future.set_work_queue(self.work_queue)
        return waitable.execute(data)

    def close(self) -> None:
        """Ask no more; a thread that asks now ends that by itself."""
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
        waitable, wait_set = self.waitable, self._wait_set
        try:
            with ExitStack() as held:
                try:
                    held.enter_context(waitable)
                except InvalidHandle:
                    return False  # as in rclpy: it is on its way out
                wait_set.clear()
                waitable.add_to_wait_set(wait_set)
                wait_set.look()
                self._follow_timers()
                return bool(waitable.is_ready(wait_set))
        except BaseException as error:
            self._error = error
            return True

    def _follow_timers(self) -> None:
        """Look again when a timer that is waited for becomes due. Of jumps of its clock it tells itself."""
        timers = self._wait_set.timers
        for timer in self._alarms.keys() - set(timers):
            self._alarms.pop(timer).drop()
        for timer in timers:
            alarm = self._alarms.get(timer)
            if alarm is None:
                alarm = self._alarms[timer] = ClockTimerEntry(self.work_queue, timer.clock, self.wake)
            if timer.is_canceled() or timer.is_ready():
                alarm.drop()
            elif alarm.time != timer.next_call_ns:
                alarm.set(timer.next_call_ns)
