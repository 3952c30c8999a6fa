"""Item 18: each call into the transport is made to fail in turn, under a small scenario of either front.

The outcome is a typed error or nothing, in time; threads, files and sessions are as before.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from typing import TypeAlias, TypeVar

import pytest
import rclpy
from example_interfaces.action import Fibonacci
from helpers.leaks import live_threads
from helpers.loops import run
from helpers.outcomes import Outcomes
from helpers.patience import wait_for
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from std_msgs.msg import String
from std_srvs.srv import Trigger

import goalwire
from goalwire.aio.node import CONTEXTS
from goalwire.errors import DeadlineError
from goalwire.testing import VirtualClock
from goalwire.transport.faults import FailedCall, Faults
from goalwire.transport.memory.domain import DOMAINS

from .conftest import LONG_ONES, WHERE_LONG, Evidence

T = TypeVar('T')
Time: TypeAlias = AbstractContextManager[object]

TIMEOUT_S = 0.2
"""The timeout of each wait. It ends those whose fault is at the other end."""

MOST = 400
"""Calls that a scenario may make."""


def asyncio_front() -> None:
    """A topic, a call and a goal, each once."""

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        goal.feedback(sequence=[0])
        return Fibonacci.Result()

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            heard = node.subscription(String, 'chatter')
            node.publisher(String, 'chatter').publish(data='hello')
            try:
                async with asyncio.timeout(TIMEOUT_S):
                    await anext(aiter(heard))
            except TimeoutError:
                raise DeadlineError('the message did not come') from None
            node.service(Trigger, 'ask', lambda _: Trigger.Response(success=True))
            await node.client(Trigger, 'ask').call(timeout=TIMEOUT_S)
            node.action_server(Fibonacci, 'count', count)
            await node.action(Fibonacci, 'count').call(order=1, timeout=TIMEOUT_S)

    run(scenario())


def rclpy_front() -> None:
    """The same, as a program of rclpy does it."""

    def count(handle: ServerGoalHandle) -> Fibonacci.Result:
        handle.publish_feedback(Fibonacci.Feedback(sequence=[0]))
        handle.succeed()
        return Fibonacci.Result()

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return response

    def wait(future: rclpy.Future[T]) -> T:
        rclpy.spin_until_future_complete(node, future, timeout_sec=TIMEOUT_S)
        if not future.done():
            raise DeadlineError('the future stayed pending')
        result = future.result()
        assert result is not None
        return result

    with rclpy.init(args=[]):
        node = rclpy.create_node('node')
        heard: rclpy.Future[object] = rclpy.Future()
        node.create_subscription(String, 'chatter', heard.set_result, 10)
        node.create_publisher(String, 'chatter', 10).publish(String(data='hello'))
        wait(heard)
        node.create_service(Trigger, 'ask', answer)
        client = node.create_client(Trigger, 'ask')
        client.wait_for_service(TIMEOUT_S)
        wait(client.call_async(Trigger.Request()))
        ActionServer(node, Fibonacci, 'count', count)
        sender = ActionClient(node, Fibonacci, 'count')
        sender.wait_for_server(TIMEOUT_S)
        goal = wait(sender.send_goal_async(Fibonacci.Goal(order=1)))
        wait(goal.get_result_async())
        node.destroy_node()


def left_behind(before: set[threading.Thread]) -> list[str]:
    """Name what a scenario has left; files are looked at when the test ends."""
    with suppress(AssertionError):  # a thread that is just beginning cannot be joined
        wait_for(lambda: not live_threads() - before)
    left = [thread.name for thread in live_threads() - before]
    if DOMAINS.users() or CONTEXTS.open:
        left.append('a session')
    return left


def fail_each_call(
    scenario: Callable[[], None], faults: Faults, outcomes: Outcomes, time: Callable[[], Time]
) -> list[str]:
    """Run a scenario with its first call failing, its second, and so on; return what was wrong."""
    problems = []
    for number in range(1, MOST):
        fault = faults.add(FailedCall(nth=number))
        before = live_threads()
        try:
            with outcomes.counted(), time():
                scenario()
        except BaseException as error:
            problems.append(f'{fault.struck_method} (call {number}): {type(error).__name__}: {error}')
        left = left_behind(before)
        if left:
            problems.append(f'{fault.struck_method} (call {number}) left {left}')
        faults.heal()
        if not fault.struck:
            return problems
    return [*problems, f'the scenario makes more than {MOST} calls']


@pytest.mark.filterwarnings('ignore::pytest.PytestUnraisableExceptionWarning')
@pytest.mark.parametrize('scenario', [asyncio_front, rclpy_front])
def test_whichever_call_of_the_transport_fails_the_error_is_typed_and_nothing_is_left(
    isolated: dict[str, str], transport_name: str, evidence: Evidence, scenario: Callable[[], None]
) -> None:
    outcomes = Outcomes()
    is_virtual = transport_name == 'goalwire_memory'
    if not is_virtual and not LONG_ONES:
        pytest.skip(WHERE_LONG)
    with Faults() as faults:
        assert fail_each_call(scenario, faults, outcomes, VirtualClock if is_virtual else nullcontext) == []
    assert outcomes.total > 30
    outcomes.slowest = None  # from the beginning of the scenario, which says nothing
    evidence(18, f'each call into the transport fails once, {scenario.__name__.replace("_", " ")}', outcomes)
