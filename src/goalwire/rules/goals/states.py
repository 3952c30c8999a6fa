"""The states of a goal: one table of transitions, which the server, the client, the docs and the tests use.

    ACCEPTED ──EXECUTE──► EXECUTING ──SUCCEED──► SUCCEEDED
        │                  │     └────ABORT────► ABORTED
    CANCEL_GOAL       CANCEL_GOAL
        │                  ▼
        └──────────────► CANCELING ──CANCELED──► CANCELED
                           │ └───────SUCCEED───► SUCCEEDED
                           └─────────ABORT─────► ABORTED

ACCEPTED, EXECUTING and CANCELING are active. The other three states are terminal: a goal stays in them. The
numbers are those of action_msgs/msg/GoalStatus and rcl_action_goal_event_t.
"""

from __future__ import annotations

from enum import IntEnum
from types import MappingProxyType
from typing import TYPE_CHECKING

from goalwire.errors import InvalidTransition

if TYPE_CHECKING:
    from collections.abc import Mapping


class GoalStatus(IntEnum):
    """The state of a goal. UNKNOWN means that the goal was not accepted yet, or is not known any more."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    is_active: bool
    """True from acceptance to the end."""
    is_terminal: bool
    """True once the goal has ended."""
    is_cancelable: bool
    """True if the table allows CANCEL_GOAL: the user may still be asked to cancel the goal."""

    def __init__(self, _number: int) -> None:
        self.is_active = 1 <= self <= 3
        self.is_terminal = self >= 4


class GoalEvent(IntEnum):
    """The events that change a goal's state."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


TABLE: Mapping[GoalStatus, Mapping[GoalEvent, GoalStatus]] = MappingProxyType(
    {
        GoalStatus.ACCEPTED: {
            GoalEvent.EXECUTE: GoalStatus.EXECUTING,
            GoalEvent.CANCEL_GOAL: GoalStatus.CANCELING,
        },
        GoalStatus.EXECUTING: {
            GoalEvent.CANCEL_GOAL: GoalStatus.CANCELING,
            GoalEvent.SUCCEED: GoalStatus.SUCCEEDED,
            GoalEvent.ABORT: GoalStatus.ABORTED,
        },
        GoalStatus.CANCELING: {
            GoalEvent.SUCCEED: GoalStatus.SUCCEEDED,
            GoalEvent.ABORT: GoalStatus.ABORTED,
            GoalEvent.CANCELED: GoalStatus.CANCELED,
        },
        GoalStatus.SUCCEEDED: {},
        GoalStatus.CANCELED: {},
        GoalStatus.ABORTED: {},
    }
)

for _status in GoalStatus:
    _status.is_cancelable = GoalEvent.CANCEL_GOAL in TABLE.get(_status, {})


def after(status: GoalStatus, event: GoalEvent) -> GoalStatus:
    """Return the state to which `event` leads from a state; raises InvalidTransition."""
    try:
        return TABLE[status][event]
    except KeyError:
        raise InvalidTransition(status, event) from None
