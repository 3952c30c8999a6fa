"""Retry policies: they say when a failed request is sent again. The rules follow gRPC's proposal A6."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

from goalwire.errors import CallError, DeadlineError, ServerLostError
from goalwire.records import record


@record
class CallAttempt:
    """The record of one attempt of a call, made after the attempt's end."""

    name: str
    """The fully-qualified name of the service."""
    peers: tuple[str, ...]
    """The nodes that offered the service when the request was sent."""
    number: int
    """The number of the attempt, 1 for the first."""
    began: float
    """The time of its beginning, in s after the beginning of the call."""
    lasted: float
    """The duration of the attempt in s."""
    error: CallError | None
    """The error with which it failed; None if it was answered."""
    retry_in: float | None
    """The time in s until the request is sent again; None if it is not sent again."""


@record
class Retry:
    """A policy by which a client sends failed requests again, within the deadline of the call.

    Use it only for an idempotent service: if an answer is lost, the server handles the same request twice.
    After `attempts` attempts the call ends with the error of the last attempt.
    """

    attempts: int = 3
    """The most attempts, the first one included."""
    timeout: float | None = None
    """The time in s that each attempt may take; None: as long as the call."""
    first_delay: float = 0.1
    """The delay in s before the second attempt. Each later delay is `factor` times as long, up to
    `longest_delay`."""
    factor: float = 2.0
    longest_delay: float = 2.0
    jitter: float = 0.2
    """Each delay is changed at random by up to this part of it, so that clients do not retry all at once."""
    on: tuple[type[CallError], ...] = (ServerLostError, DeadlineError)
    """The errors after which a request is sent again. ServerFailedError, for example, would mostly recur."""
    budget: float = 10.0
    """The size of the retry budget of all calls of a client. Each failed attempt takes 1 from it. Retries
    stop while half of it or less is left."""
    refund: float = 0.1
    """The amount that an answer gives back to the budget. With 0.1, one retry in ten calls is sustainable."""
    on_attempt: Callable[[CallAttempt], object] | None = None
    """Called with each attempt after its end, on the node's executor or loop."""

    def __post_init__(self) -> None:
        """Check the policy's values. Raises ValueError for impossible numbers, TypeError for wrong types."""
        self._check_types()
        if self.attempts < 1:
            raise ValueError(f'attempts={self.attempts}: a call has one attempt at least')
        if not 0.0 <= self.jitter <= 1.0:
            raise ValueError(f'jitter={self.jitter}: give a part of the delay, 0 to 1')
        if self.timeout is not None and not self.timeout > 0:
            raise ValueError(f'timeout={self.timeout}: give a number of seconds above 0')
        for field in ('first_delay', 'factor', 'longest_delay', 'budget', 'refund'):
            value = getattr(self, field)
            if not (isfinite(value) and value >= 0):
                raise ValueError(f'{field}={value}: give a number from 0 on')
        if self.budget <= 2.0:
            raise ValueError(f'budget={self.budget}: one failure would stop all retries; give more than 2')

    def _check_types(self) -> None:
        if not isinstance(self.attempts, int):
            raise TypeError(f'attempts={self.attempts!r}: give an int')
        for field in ('timeout', 'jitter', 'first_delay', 'factor', 'longest_delay', 'budget', 'refund'):
            value = getattr(self, field)
            if not isinstance(value, (int, float)) and not (field == 'timeout' and value is None):
                raise TypeError(f'{field}={value!r}: give a number')
        errors: object = self.on
        if not isinstance(errors, tuple) or not all(_is_call_error(kind) for kind in errors):
            raise TypeError(f'on={errors!r}: give a tuple of CallErrors, like (ServerLostError,)')
        if self.on_attempt is not None and not callable(self.on_attempt):
            raise TypeError(f'on_attempt={self.on_attempt!r}: give a function that takes a CallAttempt')

    def delay(self, failures: int, chance: float) -> float:
        """Return the delay in s after `failures` failed attempts; `chance` is a random number from 0 to 1."""
        try:
            steady = min(self.first_delay * self.factor ** (failures - 1), self.longest_delay)
        except OverflowError:
            steady = self.longest_delay
        return steady * (1.0 + self.jitter * (2.0 * chance - 1.0))


def _is_call_error(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, CallError)


class RetryBudget:
    """A retry budget for all calls of one client. It keeps retries from overloading a failing server.

    Failed attempts use the budget up, and answers refill it. Retries stop while half of the budget or less is
    left. If two threads update the budget at the same moment, one update may be lost, which does not matter,
    since the budget need not be exact.
    """

    def __init__(self, policy: Retry) -> None:
        self._policy = policy
        self.tokens = policy.budget

    def on_failure(self) -> None:
        """Note that an attempt has failed: take 1 from the budget."""
        self.tokens = max(self.tokens - 1.0, 0.0)

    def on_answer(self) -> None:
        """Note that an attempt was answered: give a part back to the budget."""
        self.tokens = min(self.tokens + self._policy.refund, self._policy.budget)

    @property
    def allows(self) -> bool:
        """True if the budget allows sending requests again."""
        return self.tokens > self._policy.budget / 2


class Attempts:
    """The attempts of one call. Times are in ns, by a steady clock."""

    __slots__ = ('_budget', '_chance', 'began', 'number', 'policy')

    def __init__(self, policy: Retry, budget: RetryBudget, chance: Callable[[], float]) -> None:
        """Make the record of one call. `chance` returns random numbers from 0 up to 1."""
        self.policy = policy
        self._budget = budget
        self._chance = chance
        self.number = 0
        self.began = 0

    def begin(self, now: int) -> None:
        """Note that the next attempt begins."""
        self.number += 1
        self.began = now

    def on_answer(self) -> None:
        """Note that the attempt was answered."""
        self._budget.on_answer()

    def on_failure(self, error: CallError, now: int, deadline: int | None) -> int | None:
        """Note that the attempt has failed. Return the ns until the next attempt, or None to end the call.

        The call ends if the policy does not cover the error, or its attempts, the budget or the deadline are
        used up.
        """
        self._budget.on_failure()
        policy = self.policy
        if not isinstance(error, policy.on) or self.number >= policy.attempts or not self._budget.allows:
            return None
        delay = int(policy.delay(self.number, self._chance()) * 1e9)
        return None if deadline is not None and now + delay >= deadline else delay
