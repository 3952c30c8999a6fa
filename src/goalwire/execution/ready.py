"""The queue of ready work, and the list of threads that sleep until there is some."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING
from weakref import ReferenceType, ref

from goalwire.execution.steady import STEADY

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.execution.agenda import Agenda
    from goalwire.execution.home import Home
    from goalwire.execution.lookout import Lookout
    from goalwire.execution.spinning import Ending
    from goalwire.execution.steady import SteadyClock
    from goalwire.execution.waiting import Waiter
    from goalwire.execution.work import Work


class ReadyQueue:
    """First in, first out. It takes no lock: each step is one atomic operation of a deque or a list.

    No wake-up is lost, because both sides act in opposite order. A poster appends its work, then looks for
    sleepers. A sleeper puts itself on the list, then looks for work. One of them sees the other. The thread
    that went to sleep last is woken first: its caches are warm, and the others sleep on.
    """

    __slots__ = ('_stirred', 'closed', 'is_driven', 'items', 'lookouts', 'wakers')

    def __init__(self, is_driven: Callable[[], bool] = bool) -> None:
        self.is_driven = is_driven
        """Tells whether somebody runs what is posted here."""
        self.items: deque[Work] = deque()
        self.lookouts: dict[ReferenceType[Lookout], None] = {}
        """Who is to be asked for work before any is taken; they belong to their nodes."""
        self.wakers: list[Callable[[], None]] = []
        """What wakes those that sleep here; who went to sleep last stands last."""
        self.closed = False
        """Whether nobody sleeps here any more."""
        self._stirred = False

    def post(self, work: Work) -> None:
        """Append `work` and wake one sleeper, if any: the poster's last act. Any thread."""
        self.items.append(work)
        if self.wakers:
            self.wake_one()

    def pop(self) -> Work | None:
        """The oldest ready work, or None."""
        try:
            return self.items.popleft()
        except IndexError:
            return None

    def take(self, work: Work) -> bool:
        """Take `work` out of turn; False where it is not here."""
        try:
            self.items.remove(work)
        except ValueError:
            return False
        return True

    def stir(self) -> None:
        """Let the lookouts be asked once more: by a sleeper, or by who is about to sleep. Any thread."""
        self._stirred = True
        self.wake_one()

    def add_lookout(self, lookout: Lookout) -> None:
        """Ask `lookout` from now on. Adding twice is harmless."""
        self.lookouts[ref(lookout, self._forget)] = None
        self.stir()

    def drop_lookout(self, lookout: Lookout) -> None:
        """Ask `lookout` no more; nothing where it is not asked."""
        self._forget(ref(lookout))

    def _forget(self, reference: ReferenceType[Lookout]) -> None:
        self.lookouts.pop(reference, None)

    def look_out(self) -> None:
        """Ask the lookouts; those with work post it here."""
        self._stirred = False
        for reference in list(self.lookouts):  # no tuple: see Lifeline._tell
            lookout = reference()
            if lookout is not None:
                lookout.look()

    @property
    def restless(self) -> bool:
        """Whether there is something to do before anybody sleeps."""
        return bool(self.items) or (self._stirred and bool(self.lookouts))

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
        if self.restless:
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
        ending: Ending,
        deadline: int | None,
        agenda: Agenda | None = None,
        *,
        last: bool = False,
    ) -> None:
        """Sleep in `waiter` until there may be work, `ending`, `deadline` (ns), or the agenda's next alarm.

        `last` makes this sleeper the last one to be woken by posts.
        """
        wakers, wake = self.wakers, waiter.wake
        try:
            if last:
                wakers.insert(0, wake)
            else:
                wakers.append(wake)
            # The looks come last: who posts, or sets an earlier alarm, does that first and then looks here.
            if agenda is not None:
                due = agenda.earliest
                if due is not None and (deadline is None or due < deadline):
                    deadline = due
            if self.items or (self._stirred and self.lookouts) or self.closed or ending._state:  # noqa: SLF001
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

    def reclaim(self, home: Home) -> list[Work]:
        """Take out all work of `home`, oldest first; the order of the rest stays."""
        taken = []
        for _ in range(len(self.items)):
            work = self.pop()
            if work is None:
                break
            if work.home is home:
                taken.append(work)
            else:
                self.items.append(work)
        if self.items:
            self.wake_one()
        return taken
