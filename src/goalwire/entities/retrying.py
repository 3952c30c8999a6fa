"""Performs what goalwire.rules.retries decides: sends a request again, and tells of each attempt."""

from __future__ import annotations

from random import random
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.entities.request_timeout import RequestTimeout, TimedRequest
from goalwire.errors import CallError, DeadlineError
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.monotonic import timeout_ns
from goalwire.execution.timer_heap import TimerEntry
from goalwire.logging import get_logger
from goalwire.rules.retries import Attempts, CallAttempt, Retry, RetryBudget

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.call_context import CallContext
    from goalwire.entities.node import NodeCore
    from goalwire.entities.server_wait_queue import ServerWaitQueue

RECORDS_LIMIT = 1000
"""Records that may wait for the hook; the oldest is dropped."""


class Retries:
    """What the calls of one client share: the policy, its budget, the hook."""

    def __init__(self, policy: Retry, node: NodeCore) -> None:
        """Raises TypeError for what is no policy."""
        if not isinstance(policy, Retry):
            raise TypeError(f'retry is a goalwire.Retry(…) or None, not {policy!r}')
        self.policy = policy
        self._node = node
        self._budget = RetryBudget(policy)
        hook = policy.on_attempt
        self._records: EventQueue[CallAttempt] | None = None
        if hook is not None:
            self._records = EventQueue(
                node.work_queue, None, lambda record: self._call(hook, record), depth=RECORDS_LIMIT
            )

    def guard(
        self, call_context: CallContext, line: ServerWaitQueue, request: TimedRequest
    ) -> RequestTimeout:
        """Make the guard of one call."""
        return RetryingGuard(call_context, line, request, self)

    def attempts(self) -> Attempts:
        """Begin to count for one call."""
        return Attempts(self.policy, self._budget, random)

    def tell(self, record: CallAttempt) -> None:
        """Let the hook hear of it. Any thread."""
        if self._records is not None:
            self._records.deliver(record)

    def _call(self, hook: Callable[[CallAttempt], object], record: CallAttempt) -> None:
        try:
            hook(record)
        except Exception as error:
            get_logger(self._node.logger_name).error(f"Service '{record.name}': on_attempt failed: {error!r}")

    def close(self) -> None:
        """Tell no more."""
        if self._records is not None:
            self._records.close()


class RetryingGuard(RequestTimeout):
    """Watches one request, and each of its attempts."""

    __slots__ = ('_again', '_attempts', '_early', '_is_out', '_is_sending', '_lock', '_patience', '_retries')

    def __init__(
        self, call_context: CallContext, line: ServerWaitQueue, request: TimedRequest, retries: Retries
    ) -> None:
        super().__init__(call_context, line, request)
        self._retries = retries
        self._attempts = retries.attempts()
        self._lock = Lock()
        self._is_out = False
        """True while an attempt waits for its answer."""
        self._is_sending = False
        self._early: Exception | None = None
        """How an attempt has failed while it was being sent."""
        self._patience = TimerEntry(self._out_of_patience)
        self._again = TimerEntry(self.resume)

    def _send(self) -> None:
        attempts, timeout = self._attempts, self._retries.policy.timeout
        now = self.call_context.now()
        attempts.begin(now)
        self.call_context.attempts = attempts.number
        self._is_out = self._is_sending = True
        if timeout is not None:
            self.call_context.context.deadlines.set(self._patience, now + timeout_ns(timeout))
        super()._send()
        with self._lock:
            self._is_sending, early = False, self._early
            self._early = None
        if early is not None:
            self._attempt_failed(early)
        if self._request is None:
            self._drop_alarms()  # it has ended meanwhile

    def _out_of_patience(self) -> None:
        timeout = self._retries.policy.timeout
        self._attempt_failed(
            self.call_context.error(DeadlineError, f'no answer came to an attempt within {timeout} s')
        )

    def unanswered(self, reason: str) -> None:
        self._attempt_failed(self._unanswered(reason))

    def _attempt_failed(self, error: Exception) -> None:
        request, call_context = self._request, self.call_context
        with self._lock:
            if self._is_sending:  # it can be withdrawn when it has its number
                self._early = error
                return
        if request is None or not self._take_back():
            return
        call_context.context.deadlines.drop(self._patience)
        request.withdraw()
        delay, now = None, call_context.now()
        if isinstance(error, CallError):
            delay = self._attempts.failed(error, now, call_context.deadline)
            self._tell(error, now, delay)
        if delay is None:
            self.fail(error)
            return
        call_context.context.sends.set(self._again, now + delay)
        if self._request is None:
            self._drop_alarms()

    def _take_back(self) -> bool:
        """True for the one who ends the attempt that is out."""
        with self._lock:
            was_out, self._is_out = self._is_out, False
        return was_out

    def answered(self) -> bool:
        if not self.end():
            return False
        if self._take_back():
            self._attempts.answered()
            self._tell(None, self.call_context.now(), None)
        return True

    def fail(self, error: Exception) -> None:
        if self._take_back() and isinstance(error, CallError):  # the time of the whole call is up
            now = self.call_context.now()
            self._attempts.failed(error, now, now)
            self._tell(error, now, None)
        super().fail(error)

    def end(self) -> bool:
        if not super().end():
            return False
        self._drop_alarms()
        return True

    def _drop_alarms(self) -> None:
        context = self.call_context.context
        context.deadlines.drop(self._patience)
        context.sends.drop(self._again)

    def _tell(self, error: CallError | None, now: int, delay: int | None) -> None:
        call_context, attempts = self.call_context, self._attempts
        began = (attempts.began - call_context.begun) / 1e9
        lasted = (now - attempts.began) / 1e9
        retry_in = None if delay is None else delay / 1e9
        self._retries.tell(
            CallAttempt(
                call_context.name, call_context.peers, attempts.number, began, lasted, error, retry_in
            )
        )
