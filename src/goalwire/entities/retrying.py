"""Sends requests again as goalwire.rules.retries decides, for the calls of one client."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING

from goalwire.errors import CallError
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.time.steady_clock import timeout_ns
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.logging import get_logger

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.call_deadlines import CallContext
    from goalwire.entities.node import NodeCore
    from goalwire.rules.retries import Attempts, CallAttempt, Retry

RECORDS_LIMIT = 1000
"""Records of attempts that may wait for the hook of a Retry; the oldest is dropped."""


def do_nothing() -> None:
    """Do nothing: an alarm calls this instead once its call has ended."""


class Retries:
    """The retries of one client: the policy, the budget and the hook that all its calls share."""

    def __init__(self, policy: Retry, node: NodeCore) -> None:
        """Raises TypeError for anything but a Retry."""
        from goalwire.rules.retries import Retry, RetryBudget

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

    def count(self) -> Attempts:
        """Begin to count the attempts of one call."""
        from random import random  # imported here: it takes 1 ms, and few calls are retried

        from goalwire.rules.retries import Attempts

        return Attempts(self.policy, self._budget, random)

    def tell(self, record: CallAttempt) -> None:
        """Have the hook called with an attempt. Any thread may call this."""
        if self._records is not None:
            self._records.deliver(record)

    def _call(self, hook: Callable[[CallAttempt], object], record: CallAttempt) -> None:
        try:
            hook(record)
        except Exception as error:
            get_logger(self._node.logger_name).error(f"Service '{record.name}': on_attempt failed: {error!r}")

    def close(self) -> None:
        """Stop calling the hook."""
        if self._records is not None:
            self._records.close()


class CallAttempts:
    """The attempts of one call whose client sends requests again."""

    __slots__ = (
        '_context',
        '_counted',
        '_early',
        '_is_out',
        '_is_sending',
        '_lock',
        'again',
        'patience',
        'retries',
    )

    def __init__(
        self,
        retries: Retries,
        context: CallContext,
        out_of_patience: Callable[[], None],
        send_again: Callable[[], None],
    ) -> None:
        self.retries = retries
        self._context = context
        self._counted = retries.count()
        self._lock = Lock()
        self._is_out = False
        """True while an attempt waits for its answer."""
        self._is_sending = False
        self._early: Exception | None = None
        """How an attempt has failed while it was being sent."""
        self.patience = TimerEntry(out_of_patience)
        self.again = TimerEntry(send_again)

    def begin(self) -> None:
        """Note that the request goes out, again or for the first time."""
        context, timeout = self._context, self.retries.policy.timeout
        now = context.now()
        self._counted.begin(now)
        context.attempts = self._counted.number
        self._is_out = self._is_sending = True
        if timeout is not None:
            context.context.deadlines.set(self.patience, now + timeout_ns(timeout))

    def on_send(self) -> Exception | None:
        """Note that the request has its number; return how the attempt has failed meanwhile, if it has."""
        with self._lock:
            self._is_sending, early = False, self._early
            self._early = None
        return early

    def keep_if_early(self, error: Exception) -> bool:
        """If the attempt is still being sent, keep its failure for `on_send`, and return True.

        A request can be taken back only when it has its number.
        """
        with self._lock:
            if self._is_sending:
                self._early = error
            return self._is_sending

    def take_back(self) -> bool:
        """End the attempt that is under way: True for the first caller only."""
        with self._lock:
            was_out, self._is_out = self._is_out, False
        return was_out

    def on_failure(self, error: CallError, *, is_last: bool = False) -> int | None:
        """Return the ns until the next attempt; None if there is none, for example because the call's time is
        up.
        """
        now = self._context.now()
        delay = self._counted.on_failure(error, now, now if is_last else self._context.deadline)
        self._tell(error, now, delay)
        return delay

    def on_answer(self) -> None:
        """Note that the attempt was answered."""
        self._counted.on_answer()
        self._tell(None, self._context.now(), None)

    def discard_alarms(self) -> None:
        """Cancel the alarms: the call has ended, so it neither sends again nor ends an attempt."""
        deadlines, sends = self._context.context.deadlines, self._context.context.sends
        for thread, alarm in ((deadlines, self.patience), (sends, self.again)):
            thread.discard(alarm)
            alarm.call = do_nothing

    def _tell(self, error: CallError | None, now: int, delay: int | None) -> None:
        from goalwire.rules.retries import CallAttempt

        context, counted = self._context, self._counted
        began = (counted.began - context.begun) / 1e9
        lasted = (now - counted.began) / 1e9
        retry_in = None if delay is None else delay / 1e9
        self.retries.tell(
            CallAttempt(context.name, context.peers, counted.number, began, lasted, error, retry_in)
        )
