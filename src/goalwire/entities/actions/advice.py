"""Logs each mistake in an action server's callbacks once, with the line of code to change."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from goalwire.entities.actions.server_goal_handle import CancelResponse, Failure, GoalResponse
from goalwire.errors import peer_text
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.logging import get_logger
from goalwire.places import at, caller_place, function_place

if TYPE_CHECKING:
    from collections.abc import Callable
    from enum import Enum

    from goalwire.entities.actions.server_goal_handle import ActionCallbacks, ServerGoalHandle
    from goalwire.entities.node import NodeCore

CANCEL_UNSEEN_S = 3.0
"""How long, in s, an execute callback may go on after its goal was cancelled, before a warning is logged."""


class ActionAdvice:
    """The advice that one action server logs. Each sentence is logged once."""

    def __init__(self, name: str, node: NodeCore, no_cancel: Callable[..., object]) -> None:
        """`no_cancel` is the default cancel callback, of servers that were given none."""
        self._name = name
        self._node = node
        self._no_cancel = no_cancel
        self._place = caller_place()
        self._told: set[str] = set()

    def _tell(self, key: str, text: str, place: str) -> None:
        if key not in self._told:
            self._told.add(key)
            get_logger(f'{self._node.logger_name}.action_server').warning(
                f"action '{self._name}': {text}{at(place)}"
            )

    def on_end(self, handle: ServerGoalHandle | None, callbacks: ActionCallbacks, outcome: object) -> None:
        """Check a goal whose execute callback has returned."""
        if handle is None:
            return
        execute = handle.executed_by or callbacks.execute
        if handle.is_active and not isinstance(outcome, Failure):
            self.state_not_set(execute)
        if handle.cancel_alarm is not None:
            self._node.context.deadlines.discard(handle.cancel_alarm)
            self._look_at_cancel(handle, callbacks)

    def on_cancel_answer(
        self, handle: ServerGoalHandle | None, callbacks: ActionCallbacks, answer: object
    ) -> None:
        """Check a cancel callback's answer and, seconds later, that the execute callback noticed the
        cancellation.
        """
        if handle is None:
            return
        if callbacks.cancel is self._no_cancel:
            self.no_cancel_callback(self._place)
        elif not isinstance(answer, CancelResponse):
            self.no_response(callbacks.cancel, answer, CancelResponse)
        elif answer is CancelResponse.ACCEPT and handle.cancel_alarm is None:
            deadlines = self._node.context.deadlines
            handle.cancel_alarm = TimerEntry(partial(self._look_at_cancel, handle, callbacks))
            now = self._node.context.shutdown_signal.clock.now()
            deadlines.set(handle.cancel_alarm, now + int(CANCEL_UNSEEN_S * 1e9))

    def _look_at_cancel(self, handle: ServerGoalHandle, callbacks: ActionCallbacks) -> None:
        execute = handle.executed_by or callbacks.execute
        if not handle.looked_at_cancel and execute is not None and self._node.context.ok():
            self.cancel_unseen(execute)

    def state_not_set(self, execute: object) -> None:
        """Log that an execute callback returned without setting the goal's final state."""
        self._tell(
            'state',
            f'{_name_of(execute, "the execute callback")} returned and did not say how the goal ended, so it '
            "counts as aborted: call goal_handle.succeed() before 'return', or abort() or canceled()",
            function_place(execute),
        )

    def no_response(
        self, callback: object, answer: object, expected: type[GoalResponse | CancelResponse]
    ) -> None:
        """Log that a goal or cancel callback returned neither ACCEPT nor REJECT."""
        kind, refused = ('goal', 'the goal') if expected is GoalResponse else ('cancel', 'cancelling')
        self._tell(
            kind,
            f'{_name_of(callback, f"the {kind} callback")} returned {peer_text(repr(answer), 60)}, '
            f'so {refused} is refused: return {_either(expected)}',
            function_place(callback),
        )

    def no_cancel_callback(self, place: str) -> None:
        """Log that a request to cancel a goal was refused, since the server has no cancel callback."""
        self._tell(
            'no cancel',
            'a client asked to cancel a goal, and was refused, since the server has no cancel callback: to '
            'allow it, write ActionServer(…, cancel_callback=…) with a function that returns '
            'CancelResponse.ACCEPT',
            place,
        )

    def cancel_unseen(self, execute: object) -> None:
        """Log that an execute callback goes on after its goal was cancelled."""
        self._tell(
            'unseen',
            f'the goal was cancelled, and {_name_of(execute, "the execute callback")} does not look at that: '
            "write 'if goal_handle.is_cancel_requested:' in its loop, and there call goal_handle.canceled() "
            'and return',
            function_place(execute),
        )


def _name_of(callback: object, role: str) -> str:
    name = getattr(callback, '__qualname__', None)
    return f'{role} {name}()' if name else role


def _either(expected: type[Enum]) -> str:
    return f'{expected.__name__}.ACCEPT or {expected.__name__}.REJECT'
