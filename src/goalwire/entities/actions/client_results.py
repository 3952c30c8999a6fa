"""Results of goals: who waits for them, and the requests that bring them.

A goal runs as long as it takes, a request does not: Zenoh gives one up after ten minutes, and keeps something
of it until then. So a result is asked for again; to ask twice does no harm, for a server answers each time.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from goalwire.entities.actions.goal_feedback import GoalFeedback
from goalwire.entities.actions.requests import EncodedResponseFuture
from goalwire.entities.pending_call import end_with, unanswered
from goalwire.errors import CallError, GoalwireError, InvalidHandle, ShutDownError, peer_text
from goalwire.execution.monotonic import STEADY
from goalwire.execution.timer_heap import TimerEntry
from goalwire.rules import reasons
from goalwire.rules.goals import wire
from goalwire.rules.latencies import Latencies

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.entities.call_context import CallContext
    from goalwire.execution.monotonic import SteadyClock
    from goalwire.execution.waiting import ShutdownSignal
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.table import GoalStatus
    from goalwire.transport.contract import ClientPort, Payload, Sample


class ResultFuture(EncodedResponseFuture):
    """Of a goal that has a feedback callback: it is done after that callback's last turn."""

    __slots__ = ('_feedback',)

    def __init__(
        self, results: ClientResults, call_context: CallContext | None, feedback: GoalFeedback
    ) -> None:
        super().__init__(results.client, results.client.support.get_result.decode_response, call_context)
        self._feedback = feedback

    def add_waker(self, waker: Callable[[], None]) -> None:
        if self.pending():
            self._feedback.hurry_if_stuck(blocks=False)
        super().add_waker(waker)

    def wait(
        self,
        deadline: int | None = None,
        *,
        clock: SteadyClock = STEADY,
        shutdown_signal: ShutdownSignal | None = None,
    ) -> bool:
        if self.pending():
            self._feedback.hurry_if_stuck(blocks=True)
        return super().wait(deadline, clock=clock, shutdown_signal=shutdown_signal)


class ResultWait:
    """One who waits for a goal's result; all who do share one request."""

    def __init__(self, results: ClientResults, goal_id: GoalId, future: EncodedResponseFuture) -> None:
        self._results = results
        self._goal_id = goal_id
        self._future = future

    def forget(self) -> None:
        """Wait no longer."""
        self._results.give_up(self._goal_id, self._future)


class ResultRequest:
    """The request for one goal's result. It is over when `results` holds it no more."""

    def __init__(self, results: ClientResults, goal_id: GoalId) -> None:
        self.goal_id = goal_id
        self._results = results
        self._sequence = 0
        self._is_forgotten = False

    def send(self) -> None:
        """Hand it to the wire; raises what sending raises."""
        results = self._results
        self._sequence = results.client.request(
            results.port, wire.encode_result_request(self.goal_id), self._on_reply, self._on_end
        )
        if self._is_forgotten:
            self.withdraw()  # before its number was known

    def withdraw(self) -> None:
        """Hold nothing for it in the transport."""
        self._is_forgotten = True
        sequence, self._sequence = self._sequence, 0
        if sequence:
            self._results.port.cancel(sequence)

    def _on_reply(self, sample: Sample) -> None:
        if self._results.leave(self):
            self._results.on_reply(self.goal_id, sample)

    def _on_end(self, reason: str) -> None:
        if reason == reasons.TIMEOUT:
            self._results.client.node.context.sends.soon(TimerEntry(self._send_again))
        elif self._results.leave(self):
            self._results.on_lost(self.goal_id, reason)

    def _send_again(self) -> None:
        if not self._results.holds(self):
            return
        try:
            self.send()
        except GoalwireError:  # closed, or the wire refuses it
            if self._results.leave(self):
                self._results.on_lost(self.goal_id, '')


class ClientResults:
    """The results that one action client waits for."""

    def __init__(self, client: ActionClientCore, port: ClientPort) -> None:
        self.client = client
        self.port = port
        self.durations = Latencies()
        """From goals to their results."""
        self._goals = client.goals
        self._requests: dict[GoalId, ResultRequest] = {}

    def get(self, goal_id: GoalId, call_context: CallContext | None) -> EncodedResponseFuture:
        """Ask for a goal's result; the future gives the action's GetResult response."""
        goal = self._goals.find(goal_id)
        future = (
            ResultFuture(self, call_context, goal.feedback)
            if goal is not None and isinstance(goal.feedback, GoalFeedback)
            else EncodedResponseFuture(
                self.client, self.client.support.get_result.decode_response, call_context
            )
        )
        future.request = ResultWait(self, goal_id, future)
        self.client.dispatch(self._goals.rules.on_result_request, goal_id, future)
        return future

    def request(self, goal_id: GoalId) -> None:
        """Send the request for a result that somebody wants."""
        request = ResultRequest(self, goal_id)
        with self._goals.lock:
            if goal_id in self._requests or not self._goals.rules.wants_result(goal_id):
                return  # given up meanwhile, and perhaps wanted again
            self._requests[goal_id] = request
        try:
            request.send()
        except BaseException:  # nothing was sent: the next who asks tries again
            self.leave(request)
            self._fail_all(goal_id, '')
            raise

    def give_up(self, goal_id: GoalId, future: EncodedResponseFuture) -> None:
        """Complete this future no more. With the last one that waits for it the request is forgotten, too."""
        with self._goals.lock:
            is_last = self._goals.rules.on_result_given_up(goal_id, future)
            request = self._requests.pop(goal_id, None) if is_last else None
        if is_last:
            self._goals.forget(goal_id)
        if request is not None:
            request.withdraw()

    def holds(self, request: ResultRequest) -> bool:
        """True until it has been answered, lost, or given up."""
        return self._requests.get(request.goal_id) is request

    def leave(self, request: ResultRequest) -> bool:
        """Hold it no more: True for the one caller that still found it."""
        with self._goals.lock:
            if self._requests.get(request.goal_id) is not request:
                return False
            del self._requests[request.goal_id]
            return True

    def on_reply(self, goal_id: GoalId, sample: Sample) -> None:
        """The result is there. Who waits for it is told after the feedback that came before it."""
        payload, reason = wire.split_reason(sample.payload)
        status = wire.status_of(payload)
        goal = self._goals.known(goal_id)
        if reason and not goal.reason:
            goal.reason = peer_text(reason)
            self.client.note_failure(goal_id, goal.reason)
        if goal.sent_at:
            self.durations.add(sample.received_timestamp - goal.sent_at)
        if goal.feedback is not None:
            self.client.hear_feedback()
        if isinstance(goal.feedback, GoalFeedback):
            goal.feedback.end(partial(self._tell, goal_id, status, payload))
        else:
            self._tell(goal_id, status, payload)

    def _tell(self, goal_id: GoalId, status: GoalStatus, payload: Payload) -> None:
        """Complete the futures of who waits for a result."""
        goals = self._goals
        goals.forget(goal_id)  # before anybody hears of the end, who may look at what is left
        self.client.dispatch(goals.rules.on_result, goal_id, status, payload)
        goals.advance(goal_id, status)

    def on_lost(self, goal_id: GoalId, reason: str) -> None:
        """No result will come."""
        self._goals.forget(goal_id)
        self._fail_all(goal_id, reason)
        self.client.report_lost('result', reason)

    def _fail_all(self, goal_id: GoalId, reason: str) -> None:
        self.client.dispatch(self._goals.rules.on_result_failed, goal_id, unanswered('result', reason))

    def fail(self, future: EncodedResponseFuture, error: Exception) -> None:
        """End one who waits, where its terms say so; else it stays pending, as in ROS 2."""
        call_context = future.call_terms
        if call_context is None or not future.pending():
            return
        if self.client.destroyed:
            end_with(future, InvalidHandle())
        elif not self.client.node.context.ok():
            end_with(future, ShutDownError(call_context.title))
        else:
            end_with(future, call_context.retold(error) if isinstance(error, CallError) else error)

    def close(self) -> None:
        """Hold nothing any more."""
        self._requests.clear()
