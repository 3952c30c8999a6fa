"""One call or goal of a coroutine, from beginning to deadline: how it waits, and what its errors tell."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from goalwire.entities.exceptions import ShutDownError
from goalwire.entities.graph_waiting import graph_shows
from goalwire.errors import CallError, DeadlineError, NoServerError
from goalwire.execution.asyncio_waiting import settle
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.entities.context import Context
    from goalwire.execution.bridge import Awaitable
    from goalwire.transport.contract import GraphEntity

ErrorT = TypeVar('ErrorT', bound=CallError)


class Attempt:
    """Begins when it is made. What it raises names the service or action, its server, and the time waited."""

    def __init__(self, context: Context, kind: str, name: str, timeout: float | None) -> None:
        """`kind` is 'service' or 'action', `name` fully qualified; a `timeout` (s) of None or inf has no end.

        Raises ValueError for a timeout that is not a number.
        """
        self._context = context
        self._title = f"{kind} '{name}'"
        self._name = name
        self._servers: list[GraphEntity] = []
        self._begun = context.lifeline.clock.now()
        self.deadline = None if timeout is None else _deadline(self._begun, timeout)
        """On the context's steady clock, in ns; None where there is none."""

    async def until(self, is_there: Callable[[], bool], served_as: str) -> None:
        """Wait for a server. `served_as` is the service's own name, or that of the action's first service.

        Raises NoServerError at the deadline, ShutDownError.
        """
        await self.shows(is_there, 'no server came', NoServerError)
        self._servers = self._context.graph.entities(EndpointKind.SERVICE, served_as)

    async def shows(
        self, predicate: Callable[[], bool], problem: str, kind: type[CallError] = DeadlineError
    ) -> None:
        """Wait until the graph looks as wanted. Raises `kind` at the deadline, ShutDownError."""
        if not await graph_shows(self._context, predicate, self.deadline):
            self._check_alive()
            raise self.error(kind, problem)

    async def settle(self, future: Awaitable) -> None:
        """Wait until `future` is no longer pending. Raises DeadlineError, ShutDownError."""
        if not await settle(future, self._context.lifeline, self.deadline):
            self._check_alive()
            raise self.error(DeadlineError, 'no answer came in time')

    def retold(self, error: CallError) -> CallError:
        """Add what is known here to an error of a client; one that tells it already stays as it is."""
        return error if error.name else self.error(type(error), str(error))

    def error(self, kind: type[ErrorT], problem: str) -> ErrorT:
        """Make an error that says which, who and how long."""
        waited = (self._context.lifeline.clock.now() - self._begun) / 1e9
        peers = tuple(dict.fromkeys(server.node.qualified for server in self._servers))
        served = f' of node {" and ".join(map(repr, peers))}' if peers else ''
        text = f'{self._title}{served}: {problem}; waited {waited:.3f} s'
        return kind(text, name=self._name, peers=peers, waited=waited)

    def _check_alive(self) -> None:
        if not self._context.ok():
            raise ShutDownError(self._title)


def _deadline(now: int, timeout: float) -> int | None:
    if math.isnan(timeout):
        raise ValueError('a timeout is a number of seconds, got nan')
    return None if timeout == math.inf else now + int(max(timeout, 0.0) * 1e9)
