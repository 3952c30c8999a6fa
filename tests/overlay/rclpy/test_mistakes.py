"""A beginner's mistake is reported at the place where it is made, with what to do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from example_interfaces.action import Fibonacci
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import SetBool

THE_FUNCTION_ITSELF = 'give the function itself'


@pytest.fixture
def transport_name() -> str:
    """The memory transport alone: these tests are the same on every wire."""
    return 'goalwire_memory'


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node()


def none() -> None: ...


def three(one: object, two: object, three: object) -> None: ...


async def reach(_: object) -> Fibonacci.Result:
    return Fibonacci.Result()


class Forgetful(Node):
    """Its __init__ does not call super().__init__()."""

    def __init__(self, act: str) -> None:
        if act:
            getattr(self, act)(String, 'topic', 10)


FORGOTTEN = (
    r"^Forgetful is not a node yet: Forgetful.__init__\(\) must call super\(\).__init__\('name'\) first$"
)


def test_a_node_without_super_init_says_so_where_it_is_used_first(executor: Executor) -> None:
    with pytest.raises(AttributeError, match=FORGOTTEN):
        Forgetful('create_publisher')
    forgetful = Forgetful('')
    with pytest.raises(AttributeError, match=FORGOTTEN):
        executor.add_node(forgetful)
    for use in (forgetful.get_logger, forgetful.get_name, forgetful.get_clock, forgetful.destroy_node):
        with pytest.raises(AttributeError, match=FORGOTTEN):
            use()
    with pytest.raises(AttributeError, match=r"^'Forgetful' object has no attribute 'speed'$"):
        forgetful.speed  # type: ignore[attr-defined]  # noqa: B018


def test_a_node_lacks_an_attribute_as_any_object_does(node: Node) -> None:
    with pytest.raises(
        AttributeError, match=r"^'Node' object has no attribute 'create_publisherr'$"
    ) as raised:
        node.create_publisherr  # type: ignore[attr-defined]  # noqa: B018
    assert (raised.value.name, raised.value.obj) == ('create_publisherr', node)  # for Python's "did you mean"
    assert not hasattr(node, '_speed')


def test_what_is_no_node_is_not_spun(executor: Executor) -> None:
    other: Any
    for other, text in (
        (Node, r'^a node is needed, got the class: write Node\(\), with the parentheses$'),
        (None, '^a node is needed, not None$'),
        ('arm', "^a node is needed, not 'arm'$"),
    ):
        with pytest.raises(AttributeError, match=text):
            executor.add_node(other)
        with pytest.raises(AttributeError, match=text):
            rclpy.spin_once(other, executor=executor)
        with pytest.raises(AttributeError, match=text):
            rclpy.spin(other, executor=executor)


def test_only_a_future_is_spun_for(node: Node, executor: Executor) -> None:
    other: Any
    for other in (None, SetBool.Response()):
        with pytest.raises(AttributeError, match='waits for a future, not for'):
            rclpy.spin_until_future_complete(node, other, executor)


def advice(capfd: pytest.CaptureFixture[str]) -> list[str]:
    """The warnings about callbacks that were logged since the last look."""
    lines = capfd.readouterr().err.splitlines()
    return [line for line in lines if line.startswith('[WARN]') and 'the call will fail' in line]


@pytest.mark.parametrize('given', [None, 5, 'f'])
def test_what_is_no_function_is_taken_as_in_rclpy_with_one_warning(
    node: Node, given: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    client = ActionClient(node, Fibonacci, 'fib')
    attempts: list[Callable[[], object]] = [
        lambda: node.create_timer(1.0, given),
        lambda: node.create_service(SetBool, 'switch', given),
        lambda: Future[None]().add_done_callback(given),
    ]
    if given is not None:  # which is the default
        attempts.append(lambda: client.send_goal_async(Fibonacci.Goal(), given))
        attempts.append(lambda: ActionServer(node, Fibonacci, 'fib', reach, goal_callback=given))
    for attempt in attempts:
        attempt()
        (told,) = advice(capfd)
        assert f'got {given!r}; {THE_FUNCTION_ITSELF}' in told
        assert 'the call will fail' in told


@pytest.mark.parametrize('given', [5, 'f'])
def test_what_is_no_function_is_refused_where_rclpy_refuses_it(node: Node, given: Any) -> None:
    with pytest.raises(TypeError, match='not callable') as raised:
        ActionServer(node, Fibonacci, 'fib', given)
    assert THE_FUNCTION_ITSELF in raised.value.__notes__[0]
    with pytest.raises(RuntimeError) as refused:
        node.create_subscription(String, 'topic', given, 10)
    assert THE_FUNCTION_ITSELF in str(refused.value)


def test_a_coroutine_in_place_of_its_function_is_named(node: Node, capfd: pytest.CaptureFixture[str]) -> None:
    called: Any = reach(None)
    node.create_timer(1.0, called)
    assert 'got a coroutine of reach(); give the function itself, f and not f()' in capfd.readouterr().err


@pytest.mark.parametrize('callback', [none, three], ids=['too few', 'too many'])
def test_a_function_with_other_parameters_is_taken_as_in_rclpy_with_one_warning(
    node: Node, callback: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    client, name = ActionClient(node, Fibonacci, 'fib'), callback.__name__
    for attempt, arguments in (
        (lambda: node.create_service(SetBool, 'switch', callback), 'request, response'),
        (lambda: ActionServer(node, Fibonacci, 'one', callback), 'goal_handle'),
        (lambda: ActionServer(node, Fibonacci, 'two', reach, goal_callback=callback), 'goal_request'),
        (lambda: ActionServer(node, Fibonacci, 'three', reach, cancel_callback=callback), 'goal_handle'),
        (lambda: client.send_goal_async(Fibonacci.Goal(), callback), 'feedback_message'),
    ):
        attempt()
        (told,) = advice(capfd)
        assert f'is called as {name}({arguments}), and does not take that: write ' in told
    with pytest.raises(RuntimeError, match='callable with one argument'):
        node.create_subscription(String, 'topic', callback, 10)


def test_a_timer_without_a_callback_raises_at_its_first_tick(node: Node, executor: Executor) -> None:
    executor.add_node(node)
    nothing: Any = None
    node.create_timer(0.001, nothing)
    with pytest.raises(TypeError, match="'NoneType' object is not callable"):
        executor.spin_until_future_complete(Future(), 5)


def test_a_service_whose_callback_takes_too_little_raises_at_the_first_call(
    node: Node, executor: Executor
) -> None:
    executor.add_node(node)
    few: Any = none
    node.create_service(SetBool, 'switch', few)
    answer = node.create_client(SetBool, 'switch').call_async(SetBool.Request())
    with pytest.raises(TypeError, match='takes 0 positional arguments but 2 were given'):
        executor.spin_until_future_complete(answer, 5)


@pytest.mark.parametrize('answer', [None, True, SetBool.Request()], ids=repr)
def test_a_service_that_returns_no_response_says_what_to_return(
    node: Node, executor: Executor, answer: Any
) -> None:
    node.create_service(SetBool, 'switch', lambda _request, _response: answer)
    client = node.create_client(SetBool, 'switch')
    executor.add_node(node)
    future = client.call_async(SetBool.Request())
    text = f"^Service '/switch': the callback returned {type(answer).__name__}; return the SetBool_Response"
    with pytest.raises(TypeError, match=text):
        executor.spin_until_future_complete(future, 5.0)


def test_before_init_that_is_what_is_told() -> None:
    with pytest.raises(
        rclpy.exceptions.NotInitializedException, match=r'^rclpy.init\(\) has not been called'
    ):
        Node('early', context=Context())


def test_a_refused_set_is_told_to_the_line_that_asked_and_to_no_other(
    node: Node, executor: Executor, capfd: pytest.CaptureFixture[str]
) -> None:
    """A request of another node is answered inside a spin whose line throws something away, too."""
    node.declare_parameter('speed', 1.0)
    executor.add_node(node)
    client = node.create_client(SetParameters, f'{node.get_name()}/set_parameters')
    refused = Parameter('speed', value='fast')
    asked = client.call_async(SetParameters.Request(parameters=[refused.to_parameter_msg()]))
    executor.spin_until_future_complete(asked, timeout_sec=PATIENCE)
    assert not asked.result().results[0].successful
    answers = node.set_parameters([refused])
    assert not answers[0].successful
    assert 'was not set' not in capfd.readouterr().err
    node.set_parameters([refused])
    assert f"'speed' was not set: {answers[0].reason}; speed: give a number" in capfd.readouterr().err
