"""Warns a program that its goal was not cancelled and goes on, unless the program reads the answer itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from goalwire.entities.unspun_nodes import tells_at_end
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.logging import get_logger
from goalwire.places import at
from goalwire.rules.goals.cancel_requests import CancelCode

if TYPE_CHECKING:
    from action_msgs.srv import CancelGoal

    from goalwire.entities.node import NodeCore

UNREAD_S = 2.0
"""How long, in s, a program may leave a server's refusal unread before it is warned."""


class Answered(Protocol):
    """A cancel request that was answered (CancelCall)."""

    @property
    def is_unread(self) -> bool:
        """Whether nobody has looked at the answer."""

    def result(self) -> Any:
        """Return the answer."""


def is_refusal(answer: CancelGoal.Response) -> bool:
    """Whether a server that had the goal did not cancel it. A goal that has ended needs no cancelling."""
    return not answer.goals_canceling and answer.return_code in {CancelCode.NONE, CancelCode.REJECTED}


def watch_answer(call: Answered, node: NodeCore, action: str, place: str) -> None:
    """Check the answer of a cancel request that the program's line `place` made, unless the program reads it.

    To be called when the answer has come.
    """
    context = node.context

    def look() -> None:
        if not call.is_unread or not (context.ok() or tells_at_end()):
            return
        if is_refusal(call.result()):
            tell_refusal(node, action, place)

    context.deadlines.set(TimerEntry(look), context.shutdown_signal.clock.now() + int(UNREAD_S * 1e9))


def tell_refusal(node: NodeCore, action: str, place: str) -> None:
    """Log that the goal goes on, and what to write in the client and in the server."""
    get_logger(f'{node.logger_name}.action_client').warning(
        f"action '{action}': the server refused to cancel the goal, so the goal goes on, and this line does "
        'not look at the answer: give the ActionServer cancel_callback=… with a function that returns '
        "CancelResponse.ACCEPT, and write here 'if not answer.goals_canceling:', which is true if the server "
        f'refused{at(place)}'
    )
