"""The chapter's comparison of topics, services and actions, a test a cell (docs/topics-services-actions.md).

Nodes of one process talk over each transport; the last row asks the robot's own programs.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest
import rclpy
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.robot import humanoid
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

from humanoid.mission.robot import Robot
from humanoid.model import JOINTS

WITHIN = 10.0

MakeNode = Callable[[str], Node]


@pytest.fixture
def make_node(isolated: dict[str, str]) -> Iterator[MakeNode]:
    """Nodes that spin from their making to the test's end."""
    rclpy.init(args=[])
    executor = MultiThreadedExecutor(num_threads=4)
    nodes: list[Node] = []

    def make(name: str) -> Node:
        nodes.append(rclpy.create_node(name))
        executor.add_node(nodes[-1])
        return nodes[-1]

    def spin() -> None:
        with suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=spin, name='spin')
    thread.start()
    yield make
    executor.shutdown()
    thread.join()
    for node in nodes:
        node.destroy_node()
    rclpy.shutdown()


class Gate:
    """Where a server's callback waits until the test lets it go on."""

    def __init__(self) -> None:
        self.entered = threading.Event()
        self.open = threading.Event()

    def __call__(self) -> None:
        self.entered.set()
        assert self.open.wait(WITHIN)


def result_of(future: Any) -> Any:
    """Wait for a future that another thread completes."""
    done = Collector[Any]()
    future.add_done_callback(done)
    return done.expect(timeout=WITHIN)[0].result()


def trigger_server(node: Node, answer: Callable[[], str], name: str = 'ask') -> None:
    def callback(_request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = True, answer()
        return response

    node.create_service(Trigger, name, callback, callback_group=ReentrantCallbackGroup())


def counting_server(node: Node, gate: Callable[[], None] = lambda: None) -> ActionServer:
    """Counts up to `order`, with feedback of each number; passes the gate after the first."""

    def execute(goal_handle: Any) -> Fibonacci.Result:
        counted: list[int] = []
        for number in range(goal_handle.request.order):
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                return Fibonacci.Result(sequence=counted)
            counted.append(number)
            goal_handle.publish_feedback(Fibonacci.Feedback(sequence=counted))
            if number == 0:
                gate()
        goal_handle.succeed()
        return Fibonacci.Result(sequence=counted)

    return ActionServer(
        node,
        Fibonacci,
        'count',
        execute,
        cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        callback_group=ReentrantCallbackGroup(),
    )


def counting_client(node: Node) -> ActionClient:
    client = ActionClient(node, Fibonacci, 'count')
    assert client.wait_for_server(timeout_sec=WITHIN)
    return client


def listen(node: Node) -> Collector[Int32]:
    heard: Collector[Int32] = Collector()
    node.create_subscription(Int32, 'numbers', heard, 10)
    return heard


# Pattern


def test_topics_are_published_and_subscribed_to(make_node: MakeNode) -> None:
    heard = listen(make_node('listener'))
    make_node('talker').create_publisher(Int32, 'numbers', 10).publish(Int32(data=7))
    assert [message.data for message in heard.expect()] == [7]


def test_services_are_asked_and_answer(make_node: MakeNode) -> None:
    asked: Collector[str] = Collector()

    def answer() -> str:
        asked('asked')
        return 'answer'

    trigger_server(make_node('server'), answer)
    client = make_node('client').create_client(Trigger, 'ask')
    assert client.wait_for_service(timeout_sec=WITHIN)
    assert asked.items == []
    assert result_of(client.call_async(Trigger.Request())).message == 'answer'
    assert asked.items == ['asked']


def test_actions_have_a_goal_feedback_and_a_result(make_node: MakeNode) -> None:
    with counting_server(make_node('server')):
        feedback: Collector[Any] = Collector()
        with counting_client(make_node('client')) as client:
            handle = result_of(client.send_goal_async(Fibonacci.Goal(order=3), feedback_callback=feedback))
            assert handle.accepted
            assert list(result_of(handle.get_result_async()).result.sequence) == [0, 1, 2]
            assert [list(message.feedback.sequence) for message in feedback.expect(3)] == [
                [0],
                [0, 1],
                [0, 1, 2],
            ]


# Communication


def test_topics_reach_every_subscriber(make_node: MakeNode) -> None:
    ears = [listen(make_node(f'listener_{number}')) for number in range(3)]
    make_node('talker').create_publisher(Int32, 'numbers', 10).publish(Int32(data=7))
    assert [[message.data for message in heard.expect()] for heard in ears] == [[7], [7], [7]]


def test_services_answer_only_the_client_that_asked(make_node: MakeNode) -> None:
    node = make_node('server')

    def echo(request: Any, response: Any) -> Any:
        response.sum = request.a + request.b
        return response

    from example_interfaces.srv import AddTwoInts

    node.create_service(AddTwoInts, 'add', echo)
    clients = [make_node(f'client_{number}').create_client(AddTwoInts, 'add') for number in range(3)]
    for client in clients:
        assert client.wait_for_service(timeout_sec=WITHIN)
    futures = [
        client.call_async(AddTwoInts.Request(a=100 * number, b=repeat))
        for repeat in range(5)
        for number, client in enumerate(clients)
    ]
    sums = [result_of(future).sum for future in futures]
    assert sums == [100 * number + repeat for repeat in range(5) for number in range(3)]


def test_actions_give_feedback_and_result_only_to_the_client_that_sent_the_goal(make_node: MakeNode) -> None:
    with counting_server(make_node('server')):
        feedback: list[Collector[Any]] = [Collector(), Collector()]
        with counting_client(make_node('one')) as one, counting_client(make_node('two')) as two:
            sent = [
                client.send_goal_async(Fibonacci.Goal(order=order), feedback_callback=seen)
                for client, order, seen in zip([one, two], [2, 4], feedback, strict=True)
            ]
            handles = [result_of(future) for future in sent]
            results = [result_of(handle.get_result_async()).result for handle in handles]
            assert [len(result.sequence) for result in results] == [2, 4]
            assert [len(seen.expect(count)) for seen, count in zip(feedback, [2, 4], strict=True)] == [2, 4]


# Blocking


def test_publishing_does_not_wait_for_a_subscriber(make_node: MakeNode) -> None:
    gate = Gate()
    make_node('listener').create_subscription(Int32, 'numbers', lambda _: gate(), 10)
    publisher = make_node('talker').create_publisher(Int32, 'numbers', 10)
    publisher.publish(Int32(data=1))
    assert gate.entered.wait(WITHIN)
    publisher.publish(Int32(data=2))
    assert not gate.open.is_set(), 'publish came back while the subscriber was still busy'
    gate.open.set()


def test_a_service_call_blocks_until_the_response_is_there(make_node: MakeNode) -> None:
    gate = Gate()

    def answer() -> str:
        gate()
        return 'late'

    trigger_server(make_node('server'), answer)
    client = make_node('client').create_client(Trigger, 'ask')
    assert client.wait_for_service(timeout_sec=WITHIN)
    answers: Collector[Any] = Collector()
    caller = threading.Thread(target=lambda: answers(client.call(Trigger.Request())))
    caller.start()
    assert gate.entered.wait(WITHIN)
    assert caller.is_alive()
    assert answers.items == []
    gate.open.set()
    caller.join(WITHIN)
    assert [answer.message for answer in answers.items] == ['late']


def test_sending_a_goal_does_not_wait_for_its_result(make_node: MakeNode) -> None:
    gate = Gate()
    with counting_server(make_node('server'), gate), counting_client(make_node('client')) as client:
        handle = result_of(client.send_goal_async(Fibonacci.Goal(order=2)))
        result = handle.get_result_async()
        assert gate.entered.wait(WITHIN)
        assert not result.done()
        gate.open.set()
        assert list(result_of(result).result.sequence) == [0, 1]


# Feedback


def test_topics_bring_message_after_message(make_node: MakeNode) -> None:
    heard = listen(make_node('listener'))
    publisher = make_node('talker').create_publisher(Int32, 'numbers', 10)
    for number in range(5):
        publisher.publish(Int32(data=number))
    assert [message.data for message in heard.expect(5)] == [0, 1, 2, 3, 4]


def test_services_bring_nothing_before_the_response(make_node: MakeNode) -> None:
    gate = Gate()

    def answer() -> str:
        gate()
        return 'all there is'

    trigger_server(make_node('server'), answer)
    client = make_node('client').create_client(Trigger, 'ask')
    assert client.wait_for_service(timeout_sec=WITHIN)
    arrived: Collector[Any] = Collector()
    client.call_async(Trigger.Request()).add_done_callback(arrived)
    assert gate.entered.wait(WITHIN)
    assert arrived.items == []
    gate.open.set()
    arrived.expect()
    assert len(arrived.items) == 1
    assert not hasattr(Trigger, 'Feedback')


def test_actions_bring_feedback_while_the_goal_runs(make_node: MakeNode) -> None:
    gate = Gate()
    with counting_server(make_node('server'), gate), counting_client(make_node('client')) as client:
        feedback: Collector[Any] = Collector()
        handle = result_of(client.send_goal_async(Fibonacci.Goal(order=3), feedback_callback=feedback))
        result = handle.get_result_async()
        assert len(feedback.expect(1)) == 1
        assert not result.done()
        gate.open.set()
        assert len(feedback.expect(3)) == 3
        result_of(result)


# Cancellation


def test_a_published_message_cannot_be_taken_back(make_node: MakeNode) -> None:
    heard = listen(make_node('listener'))
    node = make_node('talker')
    publisher = node.create_publisher(Int32, 'numbers', 10)
    publisher.publish(Int32(data=7))
    node.destroy_publisher(publisher)
    assert [message.data for message in heard.expect()] == [7]


def test_a_service_call_that_is_given_up_is_served_all_the_same(make_node: MakeNode) -> None:
    gate, served = Gate(), threading.Event()

    def answer() -> str:
        gate()
        served.set()
        return 'too late'

    trigger_server(make_node('server'), answer)
    client = make_node('client').create_client(Trigger, 'ask')
    assert client.wait_for_service(timeout_sec=WITHIN)
    future = client.call_async(Trigger.Request())
    assert gate.entered.wait(WITHIN)
    future.cancel()
    client.remove_pending_request(future)
    gate.open.set()
    assert served.wait(WITHIN)
    assert future.result() is None


def test_a_goal_can_be_cancelled_while_it_runs(make_node: MakeNode) -> None:
    gate = Gate()
    with counting_server(make_node('server'), gate), counting_client(make_node('client')) as client:
        handle = result_of(client.send_goal_async(Fibonacci.Goal(order=1000)))
        assert gate.entered.wait(WITHIN)
        assert len(result_of(handle.cancel_goal_async()).goals_canceling) == 1
        gate.open.set()
        answer = result_of(handle.get_result_async())
        assert (answer.status, list(answer.result.sequence)) == (5, [0])  # GoalStatus.STATUS_CANCELED


# Use case: the robot's own programs


@pytest.mark.slow
def test_sensor_data_and_state_come_by_topic(world: dict[str, str], robot: Robot) -> None:
    seen: Collector[JointState] = Collector()
    robot.node.create_subscription(JointState, 'joint_states', seen, 10)
    with humanoid('joint_state_service', env=world):
        assert len(seen.expect(25)[-1].position) == len(JOINTS)


@pytest.mark.slow
def test_quick_queries_are_services(world: dict[str, str], robot: Robot) -> None:
    with humanoid('joint_state_service', env=world) as server:
        server.expect('ready')
        robot.joint('left_knee')
        began = time.monotonic()
        for _ in range(10):
            robot.joint('left_knee')
        assert (time.monotonic() - began) / 10 < 0.1


@pytest.mark.slow
def test_long_running_tasks_are_actions(world: dict[str, str], robot: Robot) -> None:
    with (
        humanoid('joint_state_service', env=world),
        humanoid('navigation_action_server', env=world) as server,
    ):
        server.expect('ready')
        began = time.monotonic()
        with robot.drive(1.0, 0.0, allowed=10.0, timeout=WITHIN) as run:
            asked_meanwhile = [robot.joint('left_knee').position for _ in run.feedback()]
        assert run.status == 'SUCCEEDED'
        assert time.monotonic() - began > 1.0
        assert len(asked_meanwhile) >= 8
