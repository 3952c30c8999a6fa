"""Nothing is sent once the context has ended, as by a signal: all that is tried raises, on each wire."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import Event
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from geometry_msgs.msg import TransformStamped
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, result_of, wait_until
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import qos_profile_services_default
from rclpy.serialization import serialize_message
from rclpy.service_introspection import ServiceIntrospectionState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from tf2_ros import TransformBroadcaster

from goalwire.errors import ShutDownBySignalError, ShutDownError
from goalwire.execution.shutdown_signal import ShutdownSignal

pytestmark = pytest.mark.also_on_dds


class Other:
    """The robot: a node in a context of its own, which writes down what it is told to do."""

    def __init__(self) -> None:
        self.context = Context()
        self.context.init(args=[])
        self.node = Node('robot', context=self.context)
        self.told: Collector[str] = Collector()
        self.may_end = Event()
        self.node.create_subscription(String, 'topic', lambda message: self.told(message.data), 100)
        self.node.create_service(Trigger, 'service', self._serve)
        self.action = ActionServer(self.node, Fibonacci, 'action', self._execute)
        self.spinner = Spinner(MultiThreadedExecutor(4, context=self.context), self.node)

    def _serve(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.told('call')
        return response

    def _execute(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        self.told('goal')
        self.may_end.wait(PATIENCE)
        goal.succeed()
        return Fibonacci.Result()

    def close(self) -> None:
        self.may_end.set()
        self.spinner.close()
        self.context.shutdown()


@pytest.fixture
def other(isolated: dict[str, str]) -> Iterator[Other]:
    other = Other()
    yield other
    other.close()


class Program:
    """A program with every kind of thing that sends, in use already."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.node = node = LifecycleNode('program', context=context)
        node.trigger_configure()
        self.managed = node.create_lifecycle_publisher(String, 'topic', 10)
        node.trigger_activate()
        self.publisher = node.create_publisher(String, 'topic', 10)
        self.client = node.create_client(Trigger, 'service')
        self.timed_client = node.create_client(Trigger, 'service')
        self.timed_client.call_timeout = PATIENCE
        self.action = ActionClient(node, Fibonacci, 'action')
        self.timed_action = ActionClient(node, Fibonacci, 'action')
        self.timed_action.call_timeout = PATIENCE
        self.parameters = AsyncParameterClient(node, 'robot')
        self.broadcaster = TransformBroadcaster(node)
        assert self.action.wait_for_server(PATIENCE)
        assert self.client.wait_for_service(PATIENCE)
        assert self.parameters.wait_for_services(PATIENCE)
        wait_until(context, lambda: self.publisher.get_subscription_count() == 1)
        self.goal = result_of(self.action.send_goal_async(Fibonacci.Goal(order=1)))
        assert self.goal is not None

    def attempts(self) -> dict[str, Callable[[], object]]:
        """Return functions by name; each commands a robot, or asks it something."""
        goal, request, message = Fibonacci.Goal(order=1), Trigger.Request(), String(data='late')
        assert self.goal is not None
        return {
            'publish': lambda: self.publisher.publish(message),
            'publish what is serialized': lambda: self.publisher.publish(serialize_message(message)),
            'publish by a lifecycle publisher': lambda: self.managed.publish(message),
            'send_transform': lambda: self.broadcaster.sendTransform(TransformStamped()),
            'call': lambda: self.client.call(request),
            'call with timeout_sec': lambda: self.client.call(request, timeout_sec=PATIENCE),
            'call of a client with a time': lambda: self.timed_client.call(request),
            'call_async of a client with a time': lambda: self.timed_client.call_async(request),
            'send_goal': lambda: self.action.send_goal(goal),
            'send_goal_async': lambda: self.action.send_goal_async(goal),
            'send_goal of a client with a time': lambda: self.timed_action.send_goal(goal),
            'send_goal_async of a client with a time': lambda: self.timed_action.send_goal_async(goal),
            'cancel_goal': self.goal.cancel_goal,
            'cancel_goal_async': self.goal.cancel_goal_async,
            'cancel_all_goals_async': self.action.cancel_all_goals_async,
            'get_result': self.goal.get_result,
            'get_result_async': self.goal.get_result_async,
        }


def test_whatever_a_program_sends_after_the_end_raises_and_does_not_arrive(
    other: Other, context: Context
) -> None:
    program = Program(context)
    other.told.expect(1, PATIENCE)  # the goal
    context.shutdown_signal.end('SIGTERM')  # what the handler does
    assert not context.ok()
    outcomes: dict[str, object] = {}
    for what, attempt in program.attempts().items():
        try:
            outcomes[what] = f'went through: {attempt()}'
        except ShutDownError as error:
            outcomes[what] = 'the context was shut down' in str(error)
    assert outcomes == dict.fromkeys(outcomes, True)
    fence = Node('fence', context=other.context)
    fence.create_client(Trigger, 'service').call(Trigger.Request())
    assert other.told.items == ['goal', 'call']


def test_the_same_is_so_after_shutdown(other: Other, context: Context) -> None:
    program = Program(context)
    context.shutdown()
    for attempt in program.attempts().values():
        with pytest.raises(ShutDownError):
            attempt()


def test_a_request_after_the_end_raises_nothing_and_does_not_arrive(
    other: Other, context: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    """Destructors of ROS 2's programs send a last request; rclpy leaves them a future that stays pending."""
    program = Program(context)
    other.told.expect(1, PATIENCE)  # the goal, which a busy machine executes later than the call below
    context.shutdown_signal.end('SIGTERM')
    capfd.readouterr()
    futures: list[Any] = [program.client.call_async(Trigger.Request()) for _ in range(2)]
    futures.append(program.parameters.get_parameters(['a']))
    assert not any(future.done() for future in futures)
    told = [line for line in capfd.readouterr().err.splitlines() if "cannot call '/service'" in line]
    assert len(told) == 1
    assert told[0].endswith('The future stays pending, as in ROS 2')
    fence = Node('fence', context=other.context)
    fence.create_client(Trigger, 'service').call(Trigger.Request())
    assert other.told.items == ['goal', 'call']


def test_who_sees_that_the_context_has_ended_is_refused(other: Other, context: Context) -> None:
    """There is no moment in between: publishing is refused before ok() is False."""
    program = Program(context)
    refused: list[type[BaseException]] = []

    def command() -> None:
        assert not context.ok()
        try:
            program.publisher.publish(String(data='late'))
        except ShutDownError as error:
            refused.append(type(error))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ShutdownSignal, '_tell', lambda _: command())  # the first moment in which ok() is False
        context.shutdown_signal.end('SIGTERM')
    assert refused == [ShutDownBySignalError]


def test_a_server_answers_what_it_was_asked_but_gives_no_feedback_any_more(
    other: Other, context: Context
) -> None:
    begun, may_end = Event(), Event()
    raised: Collector[str] = Collector()
    node = Node('server', context=context)

    def serve(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        begun.set()
        may_end.wait(PATIENCE)
        response.message = 'answered after the end'
        return response

    def execute(goal: ServerGoalHandle) -> Fibonacci.Result:
        begun.set()
        may_end.wait(PATIENCE)
        try:
            goal.publish_feedback(Fibonacci.Feedback())
        except ShutDownError as error:
            raised(str(error))
        goal.succeed()
        return Fibonacci.Result()

    service = node.create_service(Trigger, 'late', serve)
    service.configure_introspection(
        node.get_clock(), qos_profile_services_default, ServiceIntrospectionState.METADATA
    )
    ActionServer(node, Fibonacci, 'late_action', execute)
    client = other.node.create_client(Trigger, 'late')
    action = ActionClient(other.node, Fibonacci, 'late_action')
    assert client.wait_for_service(PATIENCE)
    assert action.wait_for_server(PATIENCE)
    with Spinner(MultiThreadedExecutor(4, context=context), node):
        assert result_of(action.send_goal_async(Fibonacci.Goal(order=1))) is not None
        assert begun.wait(PATIENCE)
        begun.clear()
        answer = client.call_async(Trigger.Request())
        assert begun.wait(PATIENCE)
        context.shutdown_signal.end('SIGTERM')
        may_end.set()
        told = result_of(answer)
        assert told is not None
        assert told.message == 'answered after the end'
        assert 'cannot publish feedback' in raised.expect(1, PATIENCE)[0]


def test_lines_that_are_logged_and_parameters_that_are_set_after_the_end_raise_nothing(
    context: Context,
) -> None:
    node = Node('program', context=context)
    node.declare_parameter('speed', 1)
    context.shutdown_signal.end('SIGTERM')
    node.get_logger().info('goes to the console')
    get_logger('program').warning('so does this')
    node.set_parameters([node.get_parameter('speed')])


def test_new_endpoints_are_refused_too(context: Context) -> None:
    node = Node('program', context=context)
    context.shutdown_signal.end('SIGTERM')
    with pytest.raises(ShutDownError):
        node.create_publisher(String, 'topic', 10)
