"""After January 2038: stamps are int32 seconds, and everything works on with the last one."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator

import pytest
import rclpy
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.loops import run
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, result_of, wait_until
from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_services_default
from rclpy.service_introspection import ServiceIntrospectionState
from std_srvs.srv import Trigger

import goalwire
from goalwire.execution.time.steady_clock import SteadyClock
from goalwire.rules.goals.states import GoalStatus

LATER = 4_000_000_000 * 10**9
LAST = (2**31 - 1, 10**9 - 1)


@pytest.fixture(autouse=True)
def year_2096(monkeypatch: pytest.MonkeyPatch) -> None:
    began = time.time_ns()
    later = staticmethod(lambda now=time.time_ns: LATER + now() - began)
    monkeypatch.setattr(SteadyClock, 'system_now', later)
    monkeypatch.setattr(time, 'time_ns', later.__func__)


@pytest.fixture
def node(isolated: dict[str, str]) -> Iterator[Node]:
    with rclpy.init(), MultiThreadedExecutor(4) as executor:
        node = Node('late')
        with Spinner(executor, node):
            yield node


def execute(handle: ServerGoalHandle) -> Fibonacci.Result:
    handle.succeed()
    return Fibonacci.Result(sequence=[3])


def test_goals_are_served(node: Node) -> None:
    assert node.get_clock().now().nanoseconds >= LATER
    server = ActionServer(node, Fibonacci, 'count', execute, cancel_callback=lambda _: CancelResponse.ACCEPT)
    client = ActionClient(node, Fibonacci, 'count')
    assert client.wait_for_server(10)
    for _ in range(2):
        handle = result_of(client.send_goal_async(Fibonacci.Goal()))
        assert handle.accepted
        assert (handle.stamp.sec, handle.stamp.nanosec) == LAST
        answer = result_of(handle.get_result_async())
        assert (answer.status, list(answer.result.sequence)) == (GoalStatus.SUCCEEDED, [3])
    assert server.reactor.statistics().active == 0


def test_the_asyncio_server_serves_and_cancels_goals(isolated: dict[str, str]) -> None:
    begun = asyncio.Event()

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        begun.set()
        await asyncio.sleep(0 if goal.request.order else 3600)
        return Fibonacci.Result(sequence=[3])

    async def scenario() -> None:
        async with goalwire.Node('late') as node:
            server = node.action_server(Fibonacci, 'count', count)
            client = node.action(Fibonacci, 'count')
            async with client.send(order=1, timeout=PATIENCE) as goal:
                assert list((await goal.result).sequence) == [3]
            async with client.send(order=0, timeout=PATIENCE):
                await begun.wait()
            async with client.send(order=1, timeout=PATIENCE) as goal:
                await goal.result
            goals = server.statistics().goals
            assert (goals.accepted, goals.active, goals.canceled) == (3, 0, 1)

    run(scenario())


def test_rosout_parameter_events_and_service_events_are_published(node: Node) -> None:
    logs: Collector[Log] = Collector()
    events: Collector[ParameterEvent] = Collector()
    steps: Collector[Trigger.Event] = Collector()
    node.create_subscription(Log, '/rosout', logs, 10)
    node.create_subscription(ParameterEvent, '/parameter_events', events, 10)
    node.create_subscription(Trigger.Event, 'go/_service_event', steps, 10)
    wait_until(node.context, lambda: node.count_publishers('/rosout') == 1)
    service = node.create_service(Trigger, 'go', lambda _, response: response)
    service.configure_introspection(
        node.get_clock(), qos_profile_services_default, ServiceIntrospectionState.METADATA
    )
    node.declare_parameter('late', 1)
    assert node.set_parameters([Parameter('late', value=2)])[0].successful
    node.get_logger().info('late')
    client = node.create_client(Trigger, 'go')
    assert client.wait_for_service(10)
    assert client.call(Trigger.Request(), timeout_sec=PATIENCE) is not None
    for stamp in (
        logs.expect()[0].stamp,
        events.wait_for(lambda seen: any(event.changed_parameters for event in seen))[-1].stamp,
        steps.expect(2)[0].info.stamp,
    ):
        assert (stamp.sec, stamp.nanosec) == LAST
