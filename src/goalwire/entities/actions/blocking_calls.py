"""Calls of an action client that block a thread until they are answered."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn, Protocol

from goalwire.entities.pending_call import end_with
from goalwire.errors import InvalidHandle
from goalwire.execution.future import Future, block_on, cancel_quietly

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.acceptances import Acceptances
    from goalwire.entities.node import NodeCore


class BlockingClient(Protocol):
    """An action client as its blocking calls see it (ActionClientCore)."""

    node: NodeCore
    destroyed: bool
    acceptances: Acceptances

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""

    @property
    def goal_service(self) -> str:
        """The fully-qualified name of the service that takes goals."""


class BlockingCalls:
    """The blocking calls of one action client. They need no executor."""

    def __init__(self, client: BlockingClient) -> None:
        self._client = client
        self.futures: dict[Future[Any], None] = {}
        """The futures for which threads wait."""

    def wait_for(self, ask: Callable[[], Future[Any]]) -> Any:
        """Ask the server, block until the answer is there and return it.

        Raises WouldDeadlockError, without asking the server, if the answer needs the thread that would wait;
        ShutDownError and InvalidHandle if the context ends, or the client is destroyed, before the answer is
        there.
        """
        client = self._client
        context = client.node.context
        context.deadlock_detector.check(client.node.graph, client.goal_service)
        future = ask()
        self.futures[future] = None
        client.acceptances.complete_waiting()
        try:
            if client.destroyed or not block_on(future, None, context.shutdown_signal):
                self._refuse_after_the_end()
        except BaseException:
            cancel_quietly(future)
            raise
        finally:
            self.futures.pop(future, None)
        try:
            return future.result()
        finally:
            del future  # breaks a reference cycle: the exception's traceback holds this frame

    def _refuse_after_the_end(self) -> NoReturn:
        if self._client.destroyed:
            raise InvalidHandle
        raise self._client.node.context.shutdown_signal.end_error(f"action '{self._client.full_name}'")

    def end(self) -> None:
        """End every wait with InvalidHandle: the client is destroyed."""
        for future in (*self.futures,):
            if future.pending():
                end_with(future, InvalidHandle())
