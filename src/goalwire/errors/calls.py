"""Errors of calls and goals: how they end without success, and calls that cannot be made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from goalwire.errors.base import GoalwireError, LocalError

if TYPE_CHECKING:
    from enum import IntEnum


class CallError(GoalwireError):
    """A call or a goal did not end successfully."""

    def __init__(
        self, message: str = '', *, name: str = '', peers: Sequence[str] = (), waited: float = 0.0
    ) -> None:
        super().__init__(message)
        self.name = name
        """The fully-qualified name of the service or action."""
        self.peers = tuple(peers)
        """The nodes that had a server of that name when the call was made."""
        self.waited = waited
        """The time in s for which the caller has waited."""


class NoServerError(CallError, TimeoutError):
    """No server with that name appeared in time."""


class DeadlineError(CallError, TimeoutError):
    """The answer to a call or goal did not come in time."""


class ServerLostError(CallError):
    """The server disappeared before it answered, or no longer knows the goal."""


class ServerStuckError(CallError):
    """The goal's server sent no sign of life for longer than the `heartbeat` that the caller has set."""


class ServerFailedError(CallError):
    """The server did not finish the request: the server's callback failed, or was stopped."""


class RefusedError(CallError):
    """The server did not accept the request: it is too busy, or cannot decode the request."""


class PermissionDeniedError(RefusedError):
    """The server's policy does not allow this identity to call it; the text names the identity, the service
    or action, and the rule.
    """


class GoalRefused(RefusedError):
    """The action server did not accept the goal."""


class GoalFailed(CallError):
    """The goal ended without success."""

    def __init__(
        self,
        message: str = '',
        *,
        result: Any = None,
        name: str = '',
        peers: Sequence[str] = (),
        waited: float = 0.0,
    ) -> None:
        super().__init__(message, name=name, peers=peers, waited=waited)
        self.result = result
        """The result that the server sent; a result with default values if it sent none."""


class GoalAborted(GoalFailed):
    """The goal was aborted. If an action server's handler raises this error, its goal ends as aborted."""


class GoalCanceled(GoalFailed):
    """The goal was cancelled."""


class InvalidTransition(LocalError, RuntimeError):
    """A goal's state does not allow this event; the text is ROS 2's own."""

    def __init__(self, status: IntEnum, event: IntEnum) -> None:
        self.status = status
        self.event = event
        super().__init__(
            'Failed to update goal state: goal_handle attempted invalid transition '
            f'from state {status.name} with event {event.name}'
        )


class GoalIdTaken(LocalError, ValueError):
    """A goal was sent with the id of another goal, which the server knows or this client follows already."""

    def __init__(
        self, goal_id: bytes, problem: str = 'is under way already: give every goal an id of its own'
    ) -> None:
        super().__init__(f'goal {goal_id.hex()} {problem}')


class WouldDeadlockError(LocalError, RuntimeError):
    """A blocking call would wait for ever: its answer needs the thread or callback group that would wait."""


class TooManyCallsError(LocalError, RuntimeError):
    """A client has so many unanswered calls that it seems to leak them."""


class DeadlockError(LocalError):
    """In virtual time every thread waits without a deadline, so that no wait could ever end."""
