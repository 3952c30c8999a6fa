"""Sees to it that a request with a deadline ends: with its answer, or an error that says why there is none.

What may end it comes on several threads: the reply, the end of its server, the deadline, the context's end,
its caller. Whoever comes first has it.
"""

from __future__ import annotations

from _thread import allocate_lock
from typing import TYPE_CHECKING, Protocol

from goalwire.errors import ClosedError, DeadlineError, ShutDownError
from goalwire.execution.timer_heap import TimerEntry
from goalwire.rules import reasons

if TYPE_CHECKING:
    from goalwire.entities.call_context import CallContext
    from goalwire.entities.server_wait_queue import ServerWaitQueue


def _nothing() -> None:
    """What an alarm rings for whose request has ended."""


class TimedRequest(Protocol):
    """A request and the future of its answer."""

    def send(self) -> None:
        """Hand the request to the wire, perhaps once more; raises what sending raises."""

    def withdraw(self) -> None:
        """Wait no longer for the answer to what was sent last."""

    def fail(self, error: Exception) -> None:
        """Hold nothing for the request any more, and complete its future with `error`."""


class RequestTimeout:
    """Watches one request. It is sent when there is a server, at once or later."""

    __slots__ = ('_alarm', '_ending', '_request', '_waits', '_was_sent', 'call_context', 'line')

    def __init__(
        self, call_context: CallContext, line: ServerWaitQueue, request: TimedRequest, *, waits: bool = True
    ) -> None:
        """`waits` False: it is sent at once, and ends where nobody is there."""
        self.call_context = call_context
        self._waits = waits
        self._was_sent = False
        self.line = line
        self._request: TimedRequest | None = request
        self._ending = allocate_lock()
        self._alarm: TimerEntry | None = None

    def begin(self) -> None:
        """Send the request, or wait for a server. Raises what sending raises; then nothing is left of it.

        Raises ShutDownError after the context's end.
        """
        call_context, line = self.call_context, self.line
        if call_context.deadline is None:
            line.endless[self] = None  # then look: who ends the context looks here after that
            if not line.watches_end:
                line.watch_end()
        if (
            not call_context.context.shutdown_signal.alive
        ):  # an alarm would ring at once, and fail a future that nobody has
            self.end()
            raise ShutDownError(call_context.title)
        if call_context.deadline is not None:
            self._alarm = TimerEntry(self._rung)
            call_context.context.deadlines.set(self._alarm, call_context.deadline)
        try:
            self._go()
        except BaseException:
            self.end()
            raise

    def _go(self) -> None:
        line = self.line
        if line.has_server():
            self.call_context.servers = line.servers
            self._send()
        elif not self._waits:
            self._send()
        else:
            line.add(self)
            if self._request is None:
                line.discard(self)  # it has ended meanwhile

    def _send(self) -> None:
        request = self._request
        if request is not None:
            self._was_sent = True
            request.send()

    def resume(self) -> None:
        """Go on, where it is not over yet, and let the future tell what goes wrong."""
        try:
            self._go()
        except Exception as error:
            self.fail(error)

    def end(self) -> bool:
        """End it: True for the one caller that comes first, who completes the future."""
        if not self._ending.acquire(False):
            return False
        self._request = None
        line, alarm = self.line, self._alarm
        if alarm is None:
            line.endless.pop(self, None)
        else:
            self.call_context.context.deadlines.drop(alarm)
            alarm.ring = _nothing  # no circle is left for the garbage collector
        if self in line.waiting:
            line.discard(self)
        return True

    answered = end
    """A reply has come: True where it is the first, and nothing else has ended the request."""

    def fail(self, error: Exception) -> None:
        """End it with `error`, unless it is over."""
        request = self._request
        if self.end() and request is not None:
            request.fail(error)

    def unanswered(self, reason: str) -> None:
        """No reply can come to what was sent last; `reason` is a server's, or ''."""
        self.fail(self._unanswered(reason))

    def _unanswered(self, reason: str) -> Exception:
        if not self.call_context.context.ok():
            return ShutDownError(self.call_context.title)
        problem = reason or 'the server went away before it answered'
        return self.call_context.error(reasons.meaning(reason), problem)

    def end_with_context(self) -> None:
        """The context has ended."""
        self.fail(ShutDownError(self.call_context.title))

    def _rung(self) -> None:
        call_context = self.call_context
        if not call_context.context.ok():
            self.end_with_context()
        elif self._lacks_server():
            self.fail(call_context.no_server())
        else:
            self.fail(call_context.error(DeadlineError, 'no answer came in time'))

    def _lacks_server(self) -> bool:
        if self._was_sent:
            return self in self.line.waiting  # to be sent again
        try:
            return not self.line.is_there()
        except ClosedError:
            return True
