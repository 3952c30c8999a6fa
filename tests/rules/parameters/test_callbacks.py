"""The order in which callbacks are asked and told, and what they see."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from goalwire.errors import CallbackError
from goalwire.rules.parameters import Outcome, Parameter, SetCallbacks
from goalwire.rules.parameters.callbacks import On

A, B = Parameter('a', value=1), Parameter('b', value=2)


@dataclass
class Said:
    """Stands for a SetParametersResult."""

    successful: bool
    reason: str = ''


@pytest.fixture
def callbacks() -> SetCallbacks:
    return SetCallbacks()


def test_without_callbacks_everything_stays_as_it_is(callbacks: SetCallbacks) -> None:
    assert callbacks.prepare([A]) == [A]
    assert callbacks.judge([A]) == Outcome(successful=True)


def test_each_callback_before_sees_the_original_and_all_that_they_return_is_set(
    callbacks: SetCallbacks,
) -> None:
    seen = []

    def adds(parameters: list[Parameter]) -> list[Parameter]:
        seen.append(parameters)
        return [*parameters, B]

    callbacks.before = [adds, adds]
    assert callbacks.prepare([A]) == [A, B, A, B]
    assert seen == [[A], [A]]


def test_the_first_refusal_ends_the_asking(callbacks: SetCallbacks) -> None:
    asked = []

    def answer(name: str, verdict: Said) -> On:
        def on(_: object) -> Said:
            asked.append(name)
            return verdict

        return on

    callbacks.on = [
        answer('x', Said(successful=True, reason='fine')),
        answer('y', Said(successful=False, reason='no')),
        answer('z', Said(successful=True)),
    ]
    assert callbacks.judge([A]) == (False, 'no')
    assert asked == ['x', 'y']


def test_a_callback_may_remove_itself_while_it_runs(callbacks: SetCallbacks) -> None:
    told: list[str] = []

    def once(_: object) -> None:
        told.append('once')
        callbacks.after.remove(once)

    callbacks.after = [once, lambda _: told.append('always')]
    callbacks.tell([A])
    callbacks.tell([A])
    assert told == ['once', 'always', 'always']


def test_a_callback_that_returns_nothing_is_named(callbacks: SetCallbacks) -> None:
    def forgetful(_: object) -> Any:
        return None

    callbacks.before, callbacks.on = [forgetful], [forgetful]
    with pytest.raises(
        CallbackError, match=r"forgetful' returned None: return the list of parameters to set"
    ):
        callbacks.prepare([A])
    with pytest.warns(UserWarning, match='so nothing is set; write .return SetParametersResult'):
        outcome = callbacks.judge([A])
    assert not outcome.successful
    assert outcome.reason.startswith('Callback returned an invalid type: ')
    assert outcome.reason.endswith("forgetful' returned None, not an rcl_interfaces.msg.SetParametersResult")
