"""The feedback of one goal on its way to the callback: after the goal's acceptance, and before its result."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.execution.current import current_groups, why_it_cannot_answer
from goalwire.execution.event_queue import EventQueue

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.transport.contract import Sample

FEEDBACK_LIMIT = 1000
"""Feedback messages that may wait for one goal's callback; the oldest is dropped and counted."""


class GoalFeedback(EventQueue['Sample | None']):
    """Calls back with each message. None, behind the last one, stands for the goal's end.

    Feedback, acceptance and result travel on different ways. What comes before the acceptance waits for
    `open`. `end` lets the result wait until the callbacks have run for all that came before it, but never
    where they could not run while somebody waits for that result: see `hurry`.
    """

    __slots__ = ('_ends', '_is_ending', '_is_opening', '_owner', '_running', 'hurried')

    def __init__(
        self,
        work_queue: NodeWorkQueue,
        group: CallbackGroup,
        handle: Callable[[Sample], object],
        owner: object,
    ) -> None:
        super().__init__(work_queue, group, handle, depth=FEEDBACK_LIMIT)  # type: ignore[arg-type]
        self._posted = True  # so that nobody posts it before `open`
        self._owner = owner
        self._is_opening = self._is_ending = False
        self._running: list[None] = []
        """One for each callback under way, where they may run beside each other."""
        self._ends: list[Callable[[], object]] = []
        self.hurried = False

    @property
    def entity(self) -> object:
        return self._owner

    def open(self, *, in_a_turn: bool) -> None:
        """The goal is accepted.

        `in_a_turn`: nobody has been told of that yet. Then one turn of the executor comes first, so that a
        done callback which the program adds before it spins is before the feedback.
        """
        self._is_opening = in_a_turn
        if in_a_turn:
            self.work_queue.post(self)
        else:
            self._go_on()

    def end(self, then: Callable[[], object]) -> None:
        """Take no more, and call `then` after the callbacks for all that waits; now, where nothing does."""
        self.closed = True
        self._ends.append(then)
        if self.hurried or not (self._posted or self._events or self._running):
            self._tell_end()
            return
        if len(self._events) == FEEDBACK_LIMIT:
            self.dropped += 1
        self._events.append(None)
        if not self._posted:
            self._go_on()

    def hurry(self) -> None:
        """Let the result wait no longer: somebody waits for it in a way that keeps the callbacks waiting."""
        self.hurried = True
        self._tell_end()

    def hurry_if_stuck(self, *, blocks: bool) -> None:
        """Hurry where the calling callback or thread, which is about to wait for the result, must.

        So it is where nobody spins, where the callback holds our group, and where it `blocks` our thread.
        """
        queue = self.work_queue.queue
        if (
            queue is None
            or not queue.is_driven()
            or self.group in current_groups()
            or (blocks and why_it_cannot_answer(self.work_queue, self.group))
        ):
            self.hurry()

    def close(self) -> None:
        super().close()
        self._ends.clear()

    def handle(self, event: Sample | None) -> object:
        if event is not None:
            return self._handle(event)
        self._tell_end()
        return None

    def run(self) -> object:
        """As an event queue does, which this takes the place of for the sake of one call less."""
        if self._is_opening:
            self._is_opening = False
            self._go_on()
            return None
        try:
            event = self._events.popleft()
        except IndexError:
            self._go_on()
            return None
        if self._alone:
            return self.handle(event) if event is None else self._handle(event)
        return self._run_beside(event)

    def _run_beside(self, event: Sample | None) -> object:
        """Run the callback while others of this goal may run."""
        running = self._running
        if event is None:
            self._is_ending = True
            self._go_on()
        else:
            running.append(None)  # before another thread may have the next event
            self._go_on()
            try:
                return self._handle(event)
            finally:
                running.pop()
                if self._is_ending and not running:
                    self._tell_end()
        if not running:
            self._tell_end()
        return None

    def _tell_end(self) -> None:
        while self._ends:
            try:
                then = self._ends.pop(0)
            except IndexError:
                return  # another thread calls it
            then()
