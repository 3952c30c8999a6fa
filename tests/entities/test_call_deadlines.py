"""The information in the errors of awaited calls."""

from __future__ import annotations

import math

import pytest
from helpers.loops import run

from goalwire.entities.call_deadlines import CallContext
from goalwire.entities.context import Context
from goalwire.errors import CallError, DeadlineError, NoServerError, ShutDownError
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import STEADY


@pytest.mark.parametrize(
    ('timeout', 'deadline'), [(None, None), (math.inf, None), (1.5, 1_500_000_000), (-3, 0)]
)
def test_a_timeout_is_a_deadline_from_now_on(timeout: float | None, deadline: int | None) -> None:
    before = STEADY.now()
    found = CallContext(Context(), 'service', '/x', timeout).deadline
    after = STEADY.now()
    if deadline is None:
        assert found is None
    else:
        assert found is not None
        assert before <= found - deadline <= after


def test_what_is_no_number_is_no_timeout() -> None:
    with pytest.raises(ValueError, match='nan'):
        CallContext(Context(), 'service', '/x', math.nan)


def test_an_error_is_retold_with_name_and_time() -> None:
    attempt = CallContext(Context(), 'service', '/x', None)
    told = attempt.retell(NoServerError('nobody'))
    assert isinstance(told, NoServerError)
    assert str(told).startswith("service '/x': nobody; waited 0.0")
    assert (told.name, told.peers) == ('/x', ())
    assert 0 <= told.waited < 60


def test_waiting_ends_with_the_future_the_deadline_or_the_context(isolated: dict[str, str]) -> None:
    async def scenario() -> None:
        with Context() as context:
            future: Future[int] = Future()
            with pytest.raises(DeadlineError, match="action '/x': no answer came in time"):
                await CallContext(context, 'action', '/x', 0.001).settle(future)
            with pytest.raises(CallError, match='too dark'):
                await CallContext(context, 'action', '/x', 0.001).shows(lambda: False, 'too dark')
            future.set_result(1)
            await CallContext(context, 'action', '/x', 0).settle(future)
            pending: Future[int] = Future()
            context.shutdown()
            with pytest.raises(ShutDownError, match="action '/x'"):
                await CallContext(context, 'action', '/x', 5.0).settle(pending)

    run(scenario())
