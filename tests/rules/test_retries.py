"""When a request is sent again."""

from __future__ import annotations

from typing import Any

import pytest

from goalwire.errors import DeadlineError, RefusedError, ServerFailedError, ServerLostError
from goalwire.rules.retries import Attempts, Retry, RetryBudget

S = 1_000_000_000
LOST, LATE, FAILED = ServerLostError('lost'), DeadlineError('late'), ServerFailedError('failed')


def attempts(policy: Retry, budget: RetryBudget | None = None, chance: float = 0.5) -> Attempts:
    return Attempts(policy, budget or RetryBudget(policy), lambda: chance)


def delays(policy: Retry, chance: float = 0.5) -> list[float | None]:
    """Return the delays, in s, of a call that fails until it is given up; None stands for giving up."""
    counted = attempts(policy, RetryBudget(Retry(budget=1000.0)), chance)
    found: list[float | None] = []
    while not found or found[-1] is not None:
        counted.begin(0)
        delay = counted.on_failure(LOST, 0, None)
        found.append(None if delay is None else delay / S)
    return found


def test_delays_double_up_to_the_longest_until_the_attempts_are_used_up() -> None:
    policy = Retry(attempts=6, first_delay=0.5, longest_delay=3.0)
    assert delays(policy) == [0.5, 1.0, 2.0, 3.0, 3.0, None]
    assert delays(Retry(attempts=1)) == [None]


@pytest.mark.parametrize(('chance', 'factor'), [(0.0, 0.8), (0.5, 1.0), (0.999999, 1.2)])
def test_jitter_spreads_a_delay_both_ways(chance: float, factor: float) -> None:
    assert delays(Retry(attempts=2, first_delay=1.0, jitter=0.2), chance)[0] == pytest.approx(
        factor, abs=1e-5
    )


@pytest.mark.parametrize(
    ('error', 'again'), [(LOST, True), (LATE, True), (FAILED, False), (RefusedError(), False)]
)
def test_only_failures_that_may_pass_are_worth_another_attempt(error: Any, again: bool) -> None:
    counted = attempts(Retry())
    counted.begin(0)
    assert (counted.on_failure(error, 0, None) is not None) is again
    asked_for = attempts(Retry(on=(ServerFailedError,)))
    asked_for.begin(0)
    assert (asked_for.on_failure(error, 0, None) is not None) is (error is FAILED)


def test_no_attempt_begins_at_the_deadline_or_after_it() -> None:
    policy = Retry(first_delay=1.0, jitter=0.0)
    for deadline, delay in ((S, None), (S + 1, S), (None, S)):
        counted = attempts(policy)
        counted.begin(0)
        assert counted.on_failure(LOST, 0, deadline) == delay


def test_a_budget_that_is_half_empty_stops_retries_until_answers_fill_it() -> None:
    policy = Retry(attempts=2, budget=4.0, refund=0.5)
    budget = RetryBudget(policy)

    def fail_once() -> bool:
        counted = attempts(policy, budget)
        counted.begin(0)
        return counted.on_failure(LOST, 0, None) is not None

    assert [fail_once() for _ in range(6)] == [True, False, False, False, False, False]
    assert budget.tokens == 0.0
    for _ in range(6):
        attempts(policy, budget).on_answer()
    assert budget.tokens == 3.0
    assert not fail_once()
    for _ in range(20):
        budget.on_answer()
    assert budget.tokens == policy.budget
    assert fail_once()


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('attempts', 0),
        ('jitter', 1.5),
        ('jitter', -0.1),
        ('timeout', 0.0),
        ('timeout', float('nan')),
        ('first_delay', -1.0),
        ('factor', float('inf')),
        ('longest_delay', float('nan')),
        ('budget', -1.0),
        ('budget', 2.0),
        ('refund', -0.1),
    ],
)
def test_numbers_that_make_no_sense_are_refused(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=f'{field}={value}'):
        Retry(**{field: value})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('attempts', 2.5),
        ('attempts', '3'),
        ('timeout', '1'),
        ('budget', None),
        ('on', LOST),
        ('on', ServerLostError),
        ('on', (ValueError,)),
        ('on_attempt', 3),
    ],
)
def test_what_is_of_another_type_is_refused_by_its_name(field: str, value: object) -> None:
    with pytest.raises(TypeError, match=f'^{field}='):
        Retry(**{field: value})  # type: ignore[arg-type]


def test_a_delay_beyond_all_numbers_is_the_longest() -> None:
    assert Retry(attempts=5000, longest_delay=3.0, jitter=0.0).delay(4999, 0.5) == 3.0
