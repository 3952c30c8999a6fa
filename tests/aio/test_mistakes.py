"""Mistakes of programs are told when they are made, by the name of what is wrong."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import Play
from std_srvs.srv import SetBool, Trigger

import goalwire
from goalwire.errors import GoalAborted


@pytest.fixture
def transport_name() -> str:
    """The memory transport, since the mistakes are told in the same way before any wire."""
    return 'goalwire_memory'


async def move(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
    return Fibonacci.Result(sequence=[goal.request.order])


def test_a_field_that_there_is_not_is_no_request_of_default_values(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            with pytest.raises(TypeError, match="SetBool_Request has no field 'dta'; it has data"):
                await node.client(SetBool, 'switch').call(dta=True)
            with pytest.raises(TypeError, match="Trigger_Request has no field 'data'; it has no fields"):
                await node.client(Trigger, 'pull').call(data=True)
            with pytest.raises(TypeError, match="no field 'ordr'; it has order"):
                node.action(Fibonacci, 'move').send(ordr=3)
            assert node.statistics().clients[0].sent == 0

    play(scenario)


@pytest.mark.parametrize(
    ('given', 'kind'),
    [
        ({'timeout': nan}, ValueError),
        ({'grace': '1'}, TypeError),
        ({'grace': nan}, ValueError),
        ({'heartbeat': '1'}, TypeError),
        ({'heartbeat': 0.0}, ValueError),
        ({'heartbeat': nan}, ValueError),
    ],
)
def test_a_goal_with_a_time_that_is_none_is_never_sent(
    play: Play, given: dict[str, Any], kind: type[Exception]
) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            server = node.action_server(Fibonacci, 'move', move)
            with pytest.raises(kind, match=f'{next(iter(given))} is a'):
                await node.action(Fibonacci, 'move').call(**given)
            assert server.statistics().goals.accepted == 0

    play(scenario)


def test_times_without_end_are_times(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot', call_timeout=inf) as node:
            node.action_server(Fibonacci, 'move', move)
            for time in (inf, 1e300):
                result = await node.action(Fibonacci, 'move').call(order=3, heartbeat=time, timeout=time)
                assert list(result.sequence) == [3]

    play(scenario)


@pytest.mark.parametrize(
    ('given', 'problem'),
    [
        ({'policy': goalwire.preempt}, 'policy is what goalwire.single'),
        ({'policy': 'single'}, "not 'single'"),
        (
            {'handler': None},
            "the handler of the action 'move' must be a function: got None; give the function itself",
        ),
        ({'accept': 3}, "accept of the action 'move' must be a function: got 3"),
        ({'on_failure': 3}, "on_failure of the action 'move' must be a function: got 3"),
        ({'handler': lambda: None}, r"the handler of the action 'move' is called as .*<lambda>\(goal\), and"),
        ({'on_failure': lambda goal: None}, r'on_failure .* called as .*<lambda>\(goal, error\), and'),
    ],
)
def test_what_a_server_cannot_use_is_refused_when_it_is_made(
    play: Play, given: dict[str, Any], problem: str
) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            with pytest.raises(TypeError, match=problem):
                node.action_server(Fibonacci, 'move', **{'handler': move, **given})

    play(scenario)


def test_a_plain_function_that_serves_goals_is_named_as_the_reason(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            plain: Any = lambda _: Fibonacci.Result()  # noqa: E731
            node.action_server(Fibonacci, 'move', plain)
            with pytest.raises(GoalAborted, match='the handler is a plain function'):
                await node.action(Fibonacci, 'move').call(timeout=9.0)

    play(scenario)


@pytest.mark.parametrize('wrong', [3, goalwire.Retry])
def test_what_is_no_policy_of_retries_is_refused(play: Play, wrong: Any) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            with pytest.raises(TypeError, match='retry is a goalwire'):
                node.client(Trigger, 'pull', retry=wrong)

    play(scenario)


def test_a_time_that_is_none_names_the_service(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            with pytest.raises(TypeError, match="service '/pull': a timeout is a number of seconds, not '1'"):
                await node.client(Trigger, 'pull').call(timeout='1')  # type: ignore[arg-type]
        with pytest.raises(ValueError, match='call_timeout is a number of seconds, not nan'):
            goalwire.Node('robot', call_timeout=nan)

    play(scenario)


def test_a_handler_that_cannot_be_called_is_told_where_it_is_given(play: Play) -> None:
    wrong: Any = lambda: None  # noqa: E731
    called: Any = move(goalwire.Goal.__new__(goalwire.Goal))

    async def scenario() -> None:
        async with goalwire.Node('robot') as node:
            with pytest.raises(
                TypeError, match=r"the service 'switch' is called as .*<lambda>\(request\), and"
            ):
                node.service(SetBool, 'switch', wrong)
            with pytest.raises(TypeError, match=r'a coroutine of move\(\); give the function itself'):
                node.service(SetBool, 'switch', called)

    play(scenario)
