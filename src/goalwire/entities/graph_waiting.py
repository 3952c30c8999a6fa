"""Threads, coroutines and requests wait here for a state of the graph. Changes wake them; nothing polls."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING, Protocol

from goalwire.entities.context import Context
from goalwire.errors import ClosedError
from goalwire.execution.time.steady_clock import deadline_after, is_machine_time
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.logging import get_logger
from goalwire.transport.contract import EndpointKind
from goalwire.transport.registry import select_identifier

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.entities.node import NodeCore
    from goalwire.graph.watch import Watch
    from goalwire.transport.contract import GraphEntity


SILENCE_S = 5.0
"""How long, in s, a program waits for a server before the log says that there is none yet."""


def wait_for_graph(
    context: Context,
    predicate: Callable[[], bool],
    timeout_sec: float | None,
    on_silence: Callable[[], object] | None = None,
) -> bool:
    """Block until `predicate()` holds (True), or until the timeout or the context's end (False).

    None and negative times wait without limit. Needs no executor. `on_silence` is called once, if the wait
    takes longer than SILENCE_S.
    """
    if predicate():
        return True
    shutdown_signal = context.shutdown_signal
    clock = shutdown_signal.clock
    deadline = deadline_after(clock, timeout_sec)
    told_at = (
        clock.now() + int(SILENCE_S * 1e9) if on_silence is not None and is_machine_time(clock) else None
    )
    waiter = shutdown_signal.new_waiter()
    changes = context.graph.on_change(waiter.wake)
    try:
        while shutdown_signal.alive:
            if predicate():
                return True
            if told_at is None or (deadline is not None and deadline <= told_at):
                if not clock.wait(waiter, deadline):
                    break
            elif not clock.wait(waiter, told_at) and on_silence is not None:
                told_at = None
                on_silence()
        return predicate()
    finally:
        changes.close()


def where(context: Context) -> str:
    """Return where a context looks for servers, for error texts: its domain and its wire."""
    return f'in domain {context.get_domain_id()} ({select_identifier()})'


class ServerWait:
    """The blocking waits of one client for its server. They log once what may be the reason that no server is
    found.
    """

    def __init__(self, node: NodeCore, kind: str, name: str, is_there: Callable[[], bool]) -> None:
        """`kind` is 'service' or 'action', `name` fully qualified."""
        self._node = node
        self._kind = kind
        self._name = name
        self._is_there = is_there
        self._told = ''
        """The hint about similar names and types that was logged last."""

    def wait(self, timeout_sec: float | None) -> bool:
        """Block until there is a server (True), or until the timeout or the context's end (False)."""
        if wait_for_graph(self._node.context, self._is_there, timeout_sec, self._tell_silence):
            return True
        if self._node.context.ok():
            self._tell_near_misses()
        return False

    def _tell_near_misses(self) -> None:
        """Warn of similar names and types in the graph, after a wait without success."""
        hint = self._find_near_misses()
        if hint and hint != self._told:
            get_logger(self._node.logger_name).warning(f"{self._kind} '{self._name}': no server came; {hint}")
        self._told = hint

    def _tell_silence(self) -> None:
        """Log that no server has come yet, where it was looked for, and which similar names the graph has."""
        from goalwire.places import at, caller_place

        context = self._node.context
        if not context.ok():
            return
        hint = self._find_near_misses() or 'start the node that offers it, or correct the name'
        get_logger(self._node.logger_name).warning(
            f"still waiting for {self._kind} '{self._name}' after {SILENCE_S:g} s, "
            f'no server is {where(context)}: {hint}{at(caller_place())}'
        )

    def _find_near_misses(self) -> str:
        from goalwire.graph.near_misses import near_misses

        return near_misses(self._node.context.graph, self._name, is_action=self._kind == 'action')


async def await_graph(context: Context, predicate: Callable[[], bool], deadline: int | None = None) -> bool:
    """Wait, in a coroutine under any asyncio loop, until `predicate()` holds (True).

    False if the context ends, or its steady clock reaches `deadline`.
    """
    from goalwire.execution.asyncio.waiting import AsyncWaiter

    if predicate():
        return True
    shutdown_signal = context.shutdown_signal
    waiter = AsyncWaiter()
    changes = context.graph.on_change(waiter.wake)
    end = shutdown_signal.watch(waiter.wake)
    try:
        while shutdown_signal.alive:
            if predicate():
                return True
            left = None if deadline is None else deadline - shutdown_signal.clock.now()
            if left is not None and left <= 0:
                return False
            await waiter.wait(left)
        return False
    finally:
        end.close()
        changes.close()


class Waiting(Protocol):
    """A request that waits for a server."""

    def resume(self) -> None:
        """Go on: there is a server now. Raises nothing."""


class ServerWaitQueue:
    """The requests of one client that wait for a server, first come first served.

    One look at the graph after each change serves all requests. A thread of the context looks and sends,
    since changes are reported on the transport's thread. A server that was seen counts as present until the
    graph changes.
    """

    def __init__(self, context: Context, is_there: Callable[[], bool], served_as: str) -> None:
        """`served_as` is the service's name, or that of an action's first service."""
        self.waiting: dict[Waiting, None] = {}
        self._context = context
        self._is_there = is_there
        self._served_as = served_as
        self.servers: Sequence[GraphEntity] = ()
        """The servers of the last look that found any."""
        self._graph = context.graph
        self._seen = -1
        """The graph's version when a server was seen last."""
        self._lock = Lock()
        self._changes: Watch[[]] | None = None
        self._alarm = TimerEntry(self._look)

    def has_server(self) -> bool:
        """Return whether there is a server. The graph is asked only if it has changed since it had one."""
        version = self._graph.version
        if version == self._seen:
            return True
        if not self._is_there():
            return False
        self.servers = self._graph.entities(EndpointKind.SERVICE, self._served_as)
        self._seen = version
        return True

    def add(self, waiting: Waiting) -> None:
        """Add a waiting request; `resume` it once there is a server."""
        with self._lock:
            self.waiting[waiting] = None
            if self._changes is not None:
                return
            self._changes = self._context.graph.on_change(self._on_change)
        self._on_change()  # a server may have come since the last look

    def discard(self, waiting: Waiting) -> None:
        """Remove a waiting request; nothing happens if it does not wait."""
        if waiting in self.waiting:
            with self._lock:
                self.waiting.pop(waiting, None)
                if not self.waiting:
                    self._close()

    def _on_change(self) -> None:
        self._context.sends.soon(self._alarm)

    def _look(self) -> None:
        try:
            if not self._is_there():
                return
        except ClosedError:
            return  # the client or its context has ended, and fails the waiting calls
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
