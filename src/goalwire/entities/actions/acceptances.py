"""The servers' answers to goals: each completes its goal's future, at once or in a turn of the executor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.actions.client_goal_handle import GoalFeedback
from goalwire.execution.event_queue import EventQueue

if TYPE_CHECKING:
    from collections.abc import Container

    from goalwire.entities.actions.client_requests import GoalCall
    from goalwire.entities.node import NodeCore
    from goalwire.execution.future import Future
    from goalwire.transport.contract import Payload


class Acceptances:
    """The answers of servers to the goals of one action client.

    A reply completes its future on the thread that brings it. If the goal's server runs in the client's own
    executor, the reply waits for a turn of this executor: the execution of the goal begins first, as in
    rclpy.
    """

    def __init__(self, node: NodeCore, goal_service: str, blocking: Container[Future[Any]]) -> None:
        """`blocking` holds the futures for which threads wait in a blocking call."""
        self._node = node
        self._goal_service = goal_service
        self._blocking = blocking
        self._waiting: EventQueue[tuple[GoalCall, Payload]] = EventQueue(
            node.work_queue, None, self._complete_in_turn
        )

    def take(self, call: GoalCall, payload: Payload) -> None:
        """Complete the future of a goal that a server has accepted or refused, now or in a turn of the
        executor.
        """
        if call not in self._blocking and self._server_shares_executor():
            self._waiting.deliver((call, payload))
            # A thread may have begun to block meanwhile: it first notes that it waits, then looks at the
            # answers
            if call in self._blocking:
                self.complete_waiting()
        else:
            _complete(call, payload)

    def complete_waiting(self) -> None:
        """Complete the futures that wait for the executor: a thread blocks, so its turn might never come."""
        while (answer := self._waiting.take()) is not None:
            _complete(*answer)

    def _complete_in_turn(self, answer: tuple[GoalCall, Payload]) -> None:
        _complete(*answer)

    def _server_shares_executor(self) -> bool:
        """Whether a server of this action runs in this client's executor, and a thread spins the executor."""
        servers = self._node.context.deadlock_detector.event_queues.get(self._goal_service)
        if not servers:
            return False
        queue = self._node.work_queue.queue
        driver = None if queue is None else queue.driver()
        if driver is None or not driver.is_driven():
            return False
        return any(server.work_queue.queue is queue for server in servers)


def _complete(call: GoalCall, payload: Payload) -> None:
    """Complete the future, and let the goal's feedback begin."""
    feedback = call.goal.feedback
    if isinstance(feedback, GoalFeedback):
        told = not call.pending() or call.set_raw(payload)
        feedback.open(in_a_turn=not told)
    else:
        call.complete(payload)
