"""Deadlines of calls and goals, and the errors that tell of them: which name, which servers, how long."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, TypeVar

from goalwire.entities.graph_waiting import await_graph, where
from goalwire.errors import CallError, DeadlineError, NoServerError, ShutDownError
from goalwire.execution.time.steady_clock import timeout_ns
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.entities.context import Context
    from goalwire.entities.node import NodeCore
    from goalwire.execution.asyncio.loop_waker import Awaitable
    from goalwire.transport.contract import GraphEntity

ErrorT = TypeVar('ErrorT', bound=CallError)


class TimedCalls:
    """A mixin of service and action clients: the default timeout of their calls."""

    node: NodeCore
    call_timeout: float | None = None
    """The default timeout of this client's calls in s; None: that of its node."""

    @property
    def default_timeout(self) -> float | None:
        """The nearest `call_timeout` in s: the client's, its node's, its context's. None: as in ROS 2."""
        nearest = self.call_timeout
        if nearest is None:
            node = self.node
            nearest = node.call_timeout
            if nearest is None:
                return node.context.call_timeout
        return nearest


class CallContext:
    """One call or goal: its beginning, its deadline, and the errors that name its service, nodes and time."""

    __slots__ = ('attempts', 'begun', 'context', 'deadline', 'kind', 'name', 'servers')

    def __init__(self, context: Context, kind: str, name: str, timeout: float | None) -> None:
        """`kind` is 'service' or 'action', `name` fully qualified; a `timeout` (s) of None or inf is no
        limit.

        Raises TypeError for a timeout that is not a number, ValueError for nan.
        """
        self.context = context
        self.kind = kind
        self.name = name
        self.servers: Sequence[GraphEntity] = ()
        """The servers that the graph showed when the request was sent."""
        self.attempts = 1
        """How often the request went out."""
        self.begun = self.context.shutdown_signal.clock.now()
        self.deadline: int | None = None
        """The deadline in ns, on the context's steady clock; None if there is no deadline."""
        if timeout is not None and timeout != inf:
            try:
                self.deadline = self.begun + max(timeout_ns(timeout), 0)
            except (TypeError, ValueError) as error:
                raise type(error)(f'{self.title}: {error}') from None

    def now(self) -> int:
        """The time on the context's steady clock, in ns."""
        return self.context.shutdown_signal.clock.now()

    @property
    def title(self) -> str:
        """The call's name in error texts: "service '/name'"."""
        return f"{self.kind} '{self.name}'"

    def see_servers(self, served_as: str) -> None:
        """Note the servers of the service `served_as`; for an action that is its first service."""
        self.servers = self.context.graph.entities(EndpointKind.SERVICE, served_as)

    @property
    def peers(self) -> tuple[str, ...]:
        """The nodes that offered the service when the request went out."""
        return tuple(dict.fromkeys(server.node.qualified for server in self.servers))

    @property
    def waited(self) -> float:
        """The time since the call began, in s."""
        return (self.now() - self.begun) / 1e9

    def left_ns(self, margin_s: float) -> int | None:
        """Return how long, in ns, the wire has to hold a request: the time left plus `margin_s`, so that this
        call times out before the wire.
        """
        deadline = self.deadline
        if deadline is None:
            return None
        left = deadline - self.context.shutdown_signal.clock.now()
        return max(left, 0) + int(margin_s * 1e9)

    def retell(self, error: CallError) -> CallError:
        """Add this call's facts to a client's error. An error that has them already stays as it is."""
        return error if error.name else self.error(type(error), str(error))

    def error(self, kind: type[ErrorT], problem: str) -> ErrorT:
        """Make an error that names the service, its nodes and the time waited."""
        waited, peers = self.waited, self.peers
        served = f' of node {" and ".join(map(repr, peers))}' if peers else ''
        often = f', {self.attempts} attempts' if self.attempts > 1 else ''
        text = f'{self.title}{served}: {problem}; waited {waited:.3f} s{often}'
        return kind(text, name=self.name, peers=peers, waited=waited)

    def no_server(self) -> NoServerError:
        """Make the error of a call that met no server. It tells where the call looked for a server, and names
        that are similar.
        """
        error = self.error(NoServerError, f'no server came {where(self.context)}')
        hint = self.hint()
        if hint:
            error.args = (f'{error}; {hint}',)
        return error

    def end_error(self) -> ShutDownError:
        """Make the error of a call whose context has ended."""
        return self.context.shutdown_signal.end_error(self.title)

    def hint(self) -> str:
        """Return a hint about similar names or types in the graph; '' if there are none."""
        from goalwire.graph.near_misses import near_misses

        return near_misses(self.context.graph, self.name, is_action=self.kind == 'action')

    def check_alive(self) -> None:
        """Raise ShutDownError if the context has ended."""
        if not self.context.ok():
            raise self.end_error()

    # -- for coroutines under any asyncio loop

    async def until(self, is_there: Callable[[], bool], served_as: str) -> None:
        """Wait for a server; see `see_servers`. Raises NoServerError at the deadline, ShutDownError."""
        if not await await_graph(self.context, is_there, self.deadline):
            self.check_alive()
            raise self.no_server()
        self.see_servers(served_as)

    async def shows(self, predicate: Callable[[], bool], problem: str) -> None:
        """Wait until `predicate` holds for the graph. Raises DeadlineError, ShutDownError."""
        if not await await_graph(self.context, predicate, self.deadline):
            self.check_alive()
            raise self.error(DeadlineError, problem)

    async def settle(self, future: Awaitable) -> None:
        """Wait until `future` is no longer pending. Raises DeadlineError, ShutDownError."""
        # imported here: asyncio is slow to import
        from goalwire.execution.asyncio.waiting import settle

        if not await settle(future, self.context.shutdown_signal, self.deadline):
            self.check_alive()
            raise self.error(DeadlineError, 'no answer came in time')
