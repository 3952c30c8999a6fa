"""Service calls and goals with a deadline for every wait, so that each of them ends.

The node spins on its own thread; callbacks only put what arrives into a queue, and the mission takes it
out on the main thread. So Ctrl-C interrupts a wait, never a callback.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, Self

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.client import Client
from rclpy.logging import get_logger
from rclpy.task import Future

from humanoid.mission.retry import NoAnswer
from humanoid.text import brief

FIND_WITHIN = 3.0  # s to wait for a server to appear
CANCEL_WITHIN = 2.0  # s to wait for a goal's end after the request to cancel it

STATUS_NAME = {
    GoalStatus.STATUS_UNKNOWN: 'UNKNOWN',
    GoalStatus.STATUS_SUCCEEDED: 'SUCCEEDED',
    GoalStatus.STATUS_CANCELED: 'CANCELED',
    GoalStatus.STATUS_ABORTED: 'ABORTED',
}


def wait_for(future: Future[Any], timeout: float, what: str) -> Any:
    """Wait for the future and return its result. Raises NoAnswer."""
    done: SimpleQueue[Future[Any]] = SimpleQueue()
    future.add_done_callback(done.put)
    try:
        return done.get(timeout=timeout).result()
    except Empty:
        raise NoAnswer(f'{what}: no answer within {timeout:.1f} s') from None


def call(client: Client[Any, Any], request: Any, timeout: float) -> Any:
    """Send a request and return the response; `timeout` covers the wait for the server. Raises NoAnswer."""
    deadline = time.monotonic() + timeout
    if not client.wait_for_service(timeout_sec=timeout):
        raise NoAnswer(f'{client.srv_name}: no server within {timeout:.1f} s')
    future = client.call_async(request)
    try:
        return wait_for(future, max(deadline - time.monotonic(), 0.0), client.srv_name)
    except NoAnswer:
        client.remove_pending_request(future)
        raise


class GoalRun:
    """A goal, from sending to its end. Leaving the `with` block early cancels it and waits for its end."""

    def __init__(self, client: ActionClient, name: str, goal: Any, timeout: float) -> None:
        """Send `goal`, and wait until it is accepted or refused. `timeout` s are for the whole goal.

        Raises NoAnswer.
        """
        self._name = name
        self._deadline = time.monotonic() + timeout
        self._inbox: SimpleQueue[Any] = SimpleQueue()
        self._result: Any = None
        find = min(timeout, FIND_WITHIN)
        if not client.wait_for_server(timeout_sec=find):
            raise NoAnswer(f'{name}: no action server within {find:.1f} s')
        sent = client.send_goal_async(goal, feedback_callback=self._inbox.put)
        self._handle: ClientGoalHandle = wait_for(sent, self._measure_rest(), f'{name}: goal request')
        if self.accepted:
            self._handle.get_result_async().add_done_callback(self._inbox.put)

    @property
    def accepted(self) -> bool:
        return bool(self._handle.accepted)

    @property
    def status(self) -> str:
        return STATUS_NAME[self._result.status]

    @property
    def result(self) -> Any:
        return self._result.result

    def feedback(self) -> Iterator[Any]:
        """Yield the feedback as it arrives, until the result has arrived. Raises NoAnswer at the deadline."""
        while self.accepted and self._result is None:
            try:
                arrived = self._inbox.get(timeout=self._measure_rest())
            except Empty:
                raise NoAnswer(f'{self._name}: the goal did not end in time') from None
            if isinstance(arrived, Future):
                self._result = arrived.result()
                if self.status == 'ABORTED':
                    why = brief(_reason(self.result)) or 'its server gave no reason'
                    get_logger('mission').warning(f'{self._name}: the goal was aborted: {why}')
            else:
                yield arrived.feedback

    def finish(self) -> None:
        """Wait for the result."""
        for _ in self.feedback():
            pass

    def cancel(self) -> CancelGoal.Response:
        """Request to cancel the goal; the goal's status tells later if it was cancelled. Raises NoAnswer."""
        reply: CancelGoal.Response = wait_for(
            self._handle.cancel_goal_async(), self._measure_rest(), f'{self._name}: cancel request'
        )
        return reply

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self.accepted or self._result is not None:
            return
        self._deadline = time.monotonic() + CANCEL_WITHIN
        try:
            self.cancel()
            self.finish()
        except NoAnswer:
            if error is None:
                raise

    def _measure_rest(self) -> float:
        return max(self._deadline - time.monotonic(), 0.0)


def _reason(result: Any) -> str:
    """Return a result's text: the field's name differs between our actions, control_msgs and nav2_msgs."""
    names = ('message', 'error_string', 'error_msg')
    return next((text for text in (str(getattr(result, name, '')) for name in names) if text), '')
