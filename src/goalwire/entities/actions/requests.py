"""What an action client asks of its server, to take or to cancel goals, and what becomes of the answers.

With terms a request has a guard: it waits for a server, has a deadline, and its future ends with a typed
error. Without, the future stays pending where nobody answers, as in ROS 2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.pending_call import MARGIN_S, end_with
from goalwire.errors import DeadlineError
from goalwire.execution.future import Future
from goalwire.execution.timer_heap import TimerEntry
from goalwire.rules.goals import wire

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.entities.actions.client_calls import ActionCalls
    from goalwire.entities.actions.client_goal import ClientGoal
    from goalwire.entities.actions.client_results import ResultWait
    from goalwire.entities.call_context import CallContext
    from goalwire.entities.request_timeout import RequestTimeout
    from goalwire.transport.contract import ClientPort, Payload, Sample

LATE_S = 10.0
"""How long a goal that was given up may still be accepted: it is cancelled then."""


class EncodedResponseFuture(Future[Any]):
    """Completed with a payload, which `make` turns into the result when somebody asks."""

    __slots__ = ('call_terms', 'decode', 'request')

    decode: Callable[[Any], Any]

    def __init__(
        self, client: ActionCalls, make: Callable[[Payload], Any], call_context: CallContext | None
    ) -> None:
        super().__init__(client.node.work_queue)
        self.decode = make
        self.call_terms = call_context
        """What its errors tell; None: it stays pending where nobody answers."""
        self.request: ActionRequest | ResultWait | None = None
        """What it waits for."""

    def cancel(self) -> None:
        """Give the answer up. A goal goes on, as in ROS 2."""
        if self.request is not None and self.pending():
            self.request.forget()
        super().cancel()


class ActionRequest:
    """One request: to cancel goals, or (GoalRequest) to take one."""

    waits = False
    """Whether it waits for a server; who cancels a goal has had one."""

    def __init__(
        self, client: ActionCalls, port: ClientPort, payload: bytes, future: EncodedResponseFuture
    ) -> None:
        self.client = client
        self.future = future
        self.guard: RequestTimeout | None = None
        self._port = port
        self._payload = payload
        self._sequence = 0
        self._was_sent = False
        self._is_over = False
        self._is_forgotten = False

    def begin(self) -> None:
        """Send it now, or as soon as there is a server; raises what sending raises, and leaves nothing."""
        self.client.requests[self] = None
        self.future.request = self
        try:
            if self.future.call_terms is None:
                self.send()
            else:
                self.guard = self.client.guard(self.future.call_terms, self)
                self.guard.begin()
        except BaseException:
            self.client.requests.pop(self, None)
            raise

    def send(self) -> None:
        """Hand it to the wire."""
        self._was_sent = True
        call_context = self.future.call_terms
        left = None if call_context is None else call_context.left_ns(LATE_S + MARGIN_S)
        sequence = self.client.request(self._port, self._payload, self.on_reply, self.on_end, left)
        self._sequence = sequence
        if self._is_forgotten:
            self.withdraw()

    def on_reply(self, sample: Sample) -> None:
        """The first answer counts."""
        if not self._is_over and (self.guard is None or self.guard.answered()):
            self._leave()
            self._answered(sample)

    def on_end(self, reason: str) -> None:
        """No answer can come any more."""
        if self._is_over:
            return
        if self.guard is not None:
            self.guard.unanswered(reason)
        else:
            self._leave()
            self._unanswered(reason)

    def withdraw(self) -> None:
        """Hold nothing for it in the transport."""
        self._is_forgotten = True
        sequence, self._sequence = self._sequence, 0
        if sequence:
            self._port.cancel(sequence)

    def fail(self, error: Exception) -> None:
        """It ends with `error`."""
        self._leave()
        self.withdraw()
        if self.future.pending():
            end_with(self.future, error)

    def forget(self) -> None:
        """Nobody waits for the answer any more."""
        if self.guard is not None:
            self.guard.end()
        self._leave()
        self.withdraw()

    def _leave(self) -> None:
        self._is_over = True
        self.client.requests.pop(self, None)

    def _answered(self, sample: Sample) -> None:
        self.client.complete(self.future, sample.payload)

    def _unanswered(self, reason: str) -> None:
        self.client.report_lost('cancel request', reason)


class GoalRequest(ActionRequest):
    """A goal. One that was given up is cancelled, should the server take it after all."""

    waits = True
    client: ActionClientCore

    def __init__(
        self,
        client: ActionClientCore,
        port: ClientPort,
        payload: bytes,
        future: EncodedResponseFuture,
        goal: ClientGoal,
    ) -> None:
        super().__init__(client, port, payload, future)
        self._goal = goal
        self._alarm: TimerEntry | None = None

    def on_reply(self, sample: Sample) -> None:
        if self._alarm is None:
            if self._is_over:
                self._answered(sample)  # another server's
            else:
                super().on_reply(sample)
        elif wire.is_acceptance(sample.payload):
            self.client.node.context.sends.soon(TimerEntry(self._cancel_quietly))

    def on_end(self, reason: str) -> None:
        if self._alarm is None:
            super().on_end(reason)
        else:
            self.let_go()

    def _answered(self, sample: Sample) -> None:
        self.client.on_goal_reply(self._goal, self.future, sample)

    def _unanswered(self, reason: str) -> None:
        self.client.drop(self._goal, reason)
        self.client.report_lost('goal', reason)

    def fail(self, error: Exception) -> None:
        self._leave()
        self.client.drop(self._goal, '')
        if isinstance(error, DeadlineError) and self._was_sent:
            self._await_late_accept()
        else:
            self.withdraw()
        if self.future.pending():
            end_with(self.future, error)

    def forget(self) -> None:
        super().forget()
        self.client.drop(self._goal, '')

    def give_up(self) -> None:
        """Nobody waits any more for the server to take it."""
        Future.cancel(self.future)  # who waits no longer gets no error either
        if self.guard is not None:
            self.guard.fail(DeadlineError(f"the goal for '{self.client.full_name}' was given up"))

    def _await_late_accept(self) -> None:
        context = self.client.node.context
        self._alarm = TimerEntry(self.let_go)
        self.client.await_late_accept(self)
        context.deadlines.set(self._alarm, context.shutdown_signal.clock.now() + int(LATE_S * 1e9))

    def let_go(self) -> None:
        """It is too late even for that."""
        if self._alarm is not None:
            self.client.node.context.deadlines.drop(self._alarm)
        self.client.lingering.pop(self, None)
        self.withdraw()

    def _cancel_quietly(self) -> None:
        self.let_go()
        self.client.cancel_quietly(self._goal.goal_id)
