"""The text that tells a client why there is no answer, and the error that the client makes of it."""

from __future__ import annotations

import asyncio

import pytest

from goalwire.errors import (
    PEER_TEXT_LIMIT,
    CallError,
    DeadlineError,
    RefusedError,
    ServerFailedError,
    ServerLostError,
)
from goalwire.rules import reasons


@pytest.mark.parametrize(
    ('reason', 'kind'),
    [
        ('', ServerLostError),
        (reasons.CLOSING, ServerLostError),
        ('Timeout', DeadlineError),
        (reasons.explain_refusal('10000 requests wait already'), RefusedError),
        (reasons.explain_rejection(ValueError('at byte 3')), RefusedError),
        (reasons.explain_failure(KeyError('bulb')), ServerFailedError),
        (reasons.explain_failure(asyncio.CancelledError()), ServerFailedError),
        ('whatever another server says', ServerFailedError),
    ],
)
def test_each_reason_is_one_error_of_the_client(reason: str, kind: type[CallError]) -> None:
    assert reasons.meaning(reason) is kind


def test_a_failure_is_told_by_type_and_text() -> None:
    assert reasons.explain_failure(KeyError('bulb')) == "its callback failed: KeyError: 'bulb'"
    assert reasons.explain_failure(ValueError()) == 'its callback failed: ValueError'
    assert reasons.explain_failure(SystemExit(3)) == 'its callback was stopped'


def test_a_reason_is_short() -> None:
    told = reasons.explain_failure(ValueError('x' * 10_000))
    assert len(told) == PEER_TEXT_LIMIT
    assert told.endswith('x…')
