"""Retry policies: whether and when a failed request is sent again. The rules follow gRPC's proposal A6."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

from goalwire.errors import CallError, DeadlineError, ServerLostError
from goalwire.records import record


@record
class CallAttempt:
    """One attempt of a call, after its end."""

    name: str
    """The fully-qualified name of the service."""
    peers: tuple[str, ...]
    """The nodes that served it when the request went out."""
    number: int
    """The number of the attempt, 1 for the first."""
    began: float
    """s after the beginning of the call."""
    lasted: float
    """How long it lasted, in s."""
    error: CallError | None
    """Why it failed; None if it was answered."""
    retry_in: float | None
    """s until the request is sent again; None if it is not."""


@record
class Retry:
    """How a client's requests are sent again, within the deadline of the call.

    To give it to a client is to say that its service is idempotent: a server may handle a request twice, of
    which one answer was lost. After `attempts` the call ends with the error of the last.
    """

    attempts: int = 3
    """The number of attempts, with the first one."""
    timeout: float | None = None
    """s that each attempt may take; None: as long as the call."""
    first_delay: float = 0.1
    """s before the second attempt; then `factor` times as many each time, `longest_delay` at most."""
    factor: float = 2.0
    longest_delay: float = 2.0
    jitter: float = 0.2
    """Each delay is longer or shorter by up to this part of it, so that clients do not come back at once."""
    on: tuple[type[CallError], ...] = (ServerLostError, DeadlineError)
    """The errors after which a request is sent again; one like ServerFailedError would mostly come again."""
    budget: float = 10.0
    """How many attempts in a row may fail, of all calls of the client, before half of that stops retries."""
    refund: float = 0.1
    """How much an answer gives back to the budget: with 0.1, one retry in ten calls can go on for ever."""
    on_attempt: Callable[[CallAttempt], object] | None = None
    """Called with each attempt after its end, on the node's executor or loop."""

    def __post_init__(self) -> None:
        """Raises ValueError for impossible numbers, TypeError for values of another type."""
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
        """Return the wait in s after `failures` failed attempts; `chance` is a random number from 0 up to
        1.
        """
        try:
            steady = min(self.first_delay * self.factor ** (failures - 1), self.longest_delay)
        except OverflowError:
            steady = self.longest_delay
        return steady * (1.0 + self.jitter * (2.0 * chance - 1.0))


def _is_call_error(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, CallError)


class RetryBudget:
    """A budget that keeps retries from overloading a server in trouble: retries stop while it is half empty.

    For all calls of one client. Threads may lose an update of each other's: it is a brake, not a count.
    """

    def __init__(self, policy: Retry) -> None:
        self._policy = policy
        self.tokens = policy.budget

    def on_failure(self) -> None:
        """Note that an attempt has failed."""
        self.tokens = max(self.tokens - 1.0, 0.0)

    def on_answer(self) -> None:
        """Note that a call was answered."""
        self.tokens = min(self.tokens + self._policy.refund, self._policy.budget)

    @property
    def allows(self) -> bool:
        """Whether requests may be sent again."""
        return self.tokens > self._policy.budget / 2


class Attempts:
    """The attempts of one call. Times are in ns of one steady clock."""

    __slots__ = ('_budget', '_chance', 'began', 'number', 'policy')

    def __init__(self, policy: Retry, budget: RetryBudget, chance: Callable[[], float]) -> None:
        """`chance` gives random numbers from 0 up to 1."""
        self.policy = policy
        self._budget = budget
        self._chance = chance
        self.number = 0
        self.began = 0

    def begin(self, now: int) -> None:
        """The request goes out, again or for the first time."""
        self.number += 1
        self.began = now

    def on_answer(self) -> None:
        """Note that the attempt was answered."""
        self._budget.on_answer()

    def on_failure(self, error: CallError, now: int, deadline: int | None) -> int | None:
        """The attempt has failed: return the ns until the next one, or None if the call is to end.

        It ends if the policy, its count, the budget or the call's deadline leave no room for another.
        """
        self._budget.on_failure()
        policy = self.policy
        if not isinstance(error, policy.on) or self.number >= policy.attempts or not self._budget.allows:
            return None
        delay = int(policy.delay(self.number, self._chance()) * 1e9)
        return None if deadline is not None and now + delay >= deadline else delay
