"""Requests that wait until there is somebody to send them to."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING, Protocol

from goalwire.errors import ClosedError
from goalwire.execution.timer_heap import TimerEntry
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.entities.context import Context
    from goalwire.graph.watch import Watch
    from goalwire.transport.contract import GraphEntity


class Waiting(Protocol):
    """A request in the line."""

    def resume(self) -> None:
        """There is a server now. Raises nothing."""

    def end_with_context(self) -> None:
        """The context has ended. Raises nothing."""


class ServerWaitQueue:
    """The requests of one client that wait for a server, first come first served.

    One look at the graph after each change serves them all; it and the sending happen on a thread of the
    context's, for a change comes on the transport's. A server that was seen is there until the graph changes.
    """

    def __init__(
        self,
        context: Context,
        is_there: Callable[[], bool],
        kind: str,
        name: str,
        served_as: str | None = None,
    ) -> None:
        """`kind` and `name` as CallContext has them; `served_as` is the name of an action's first service."""
        self.context = context
        self.is_there = is_there
        self.kind = kind
        self.name = name
        self.served_as = served_as or name
        self.waiting: dict[Waiting, None] = {}
        self.endless: dict[Waiting, None] = {}
        """Requests without a deadline, waiting or sent: they end with the context at the latest. Sharing its
        end costs them nothing, where an alarm each would take six calls."""
        self.watches_end = False
        """Whether somebody sees to the end of what is in `endless`."""
        self.servers: Sequence[GraphEntity] = ()
        """Who served when somebody was seen last."""
        self._graph = context.graph
        self._seen = -1
        """The graph's version when somebody was seen last."""
        self._lock = Lock()
        self._changes: Watch[[]] | None = None
        self._alarm = TimerEntry(self._look)

    def has_server(self) -> bool:
        """As `is_there`, but looks no more where the graph is as it was: twelve calls less for a request."""
        version = self._graph.version
        if version == self._seen:
            return True
        if not self.is_there():
            return False
        self.servers = self._graph.entities(EndpointKind.SERVICE, self.served_as)
        self._seen = version
        return True

    def watch_end(self) -> None:
        """See to the end of what is in `endless`."""
        self.watches_end = True
        self.context.deadlines.tell_end(self)

    def end(self) -> None:
        """The context has ended."""
        for request in list(self.endless):
            request.end_with_context()

    def add(self, waiting: Waiting) -> None:
        """Let a request wait; `resume` it once there is a server."""
        with self._lock:
            self.waiting[waiting] = None
            if self._changes is not None:
                return
            self._changes = self.context.graph.on_change(self._changed)
        self._changed()  # one may have come since somebody looked

    def discard(self, waiting: Waiting) -> None:
        """Let it wait no longer; nothing where it does not."""
        if waiting in self.waiting:
            with self._lock:
                self.waiting.pop(waiting, None)
                if not self.waiting:
                    self._close()

    def _changed(self) -> None:
        self.context.sends.soon(self._alarm)

    def _look(self) -> None:
        try:
            if not self.is_there():
                return
        except ClosedError:
            return  # the client or its context has ended, and tells who waits
        with self._lock:
            served = list(self.waiting)
            self.waiting.clear()
            self._close()
        for waiting in served:
            waiting.resume()

    def _close(self) -> None:
        changes, self._changes = self._changes, None
        if changes is not None:
            changes.close()
