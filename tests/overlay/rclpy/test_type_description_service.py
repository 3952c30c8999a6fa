"""~/get_type_description: who offers it, and what it says of the node's types."""

from __future__ import annotations

from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import ActionClient
from rclpy.exceptions import InvalidParameterTypeException, ParameterImmutableException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.type_description_service import START_TYPE_DESCRIPTION_SERVICE_PARAM, TypeDescriptionService
from std_msgs.msg import Header, String
from type_description_interfaces.srv import GetTypeDescription

from goalwire.idl import type_hash


@pytest.fixture
def node(make_node: MakeNode, spin: Spin) -> Node:
    """A spun node, /ns/uses."""
    node = make_node('uses', namespace='ns')
    spin(node)
    return node


def ask(node: Node, type_hash: str, **fields: Any) -> GetTypeDescription.Response:
    client = node.create_client(GetTypeDescription, '/ns/uses/get_type_description')
    assert client.wait_for_service(10.0)
    return result_of(client.call_async(GetTypeDescription.Request(type_hash=type_hash, **fields)))


def offered(node: Node) -> list[str]:
    names = [service.service_name for service in node.services]
    return [name for name in names if name.endswith('/get_type_description')]


def test_a_published_type_is_described_with_its_sources(node: Node) -> None:
    node.create_publisher(Header, 'x', 1)
    answer = ask(node, type_hash(Header))
    assert answer.successful
    assert answer.type_description.type_description.type_name == 'std_msgs/msg/Header'
    assert [each.type_name for each in answer.type_description.referenced_type_descriptions] == [
        'builtin_interfaces/msg/Time'
    ]
    assert [source.type_name for source in answer.type_sources] == [
        'std_msgs/msg/Header',
        'builtin_interfaces/msg/Time',
    ]


def test_sources_are_left_out_on_request(node: Node) -> None:
    node.create_publisher(String, 'x', 1)
    answer = ask(node, type_hash(String), include_type_sources=False)
    assert (answer.successful, list(answer.type_sources)) == (True, [])


def test_types_of_subscriptions_services_and_actions_are_in_use_too(node: Node) -> None:
    node.create_subscription(String, 'x', lambda _: None, 1)
    node.create_client(AddTwoInts, 'add')
    action = ActionClient(node, Fibonacci, 'fib')
    for cls in (String, AddTwoInts, Fibonacci, Fibonacci.Impl.SendGoalService):
        assert ask(node, type_hash(cls)).successful, cls
    action.destroy()


def test_the_standing_topics_are_in_use(node: Node) -> None:
    for name in ('rcl_interfaces/msg/Log', 'rcl_interfaces/msg/ParameterEvent'):
        assert ask(node, type_hash(name)).successful, name


def test_a_type_that_the_node_does_not_use_is_not_described(node: Node) -> None:
    publisher = node.create_publisher(String, 'x', 1)
    node.destroy_publisher(publisher)
    answer = ask(node, type_hash(String), type_name='std_msgs/msg/String')
    assert (answer.successful, answer.failure_reason) == (False, 'Type not currently in use by this node')


@pytest.mark.parametrize('text', ['', 'RIHS01_12', 'RIHS02_' + 64 * '0', 'RIHS01_' + 64 * 'g'])
def test_what_is_no_hash_is_refused(node: Node, text: str) -> None:
    answer = ask(node, text)
    assert (answer.successful, answer.failure_reason) == (False, 'Failed to parse type hash')


def test_the_parameter_is_read_only_and_described(make_node: MakeNode) -> None:
    node = make_node('a')
    assert offered(node) == ['/a/get_type_description']
    assert node.get_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM).value is True
    descriptor = node.describe_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM)
    assert (descriptor.read_only, descriptor.description) == (
        True,
        'If enabled, start the ~/get_type_description service.',
    )
    (result,) = node.set_parameters([Parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, value=False)])
    assert not result.successful
    with pytest.raises(ParameterImmutableException):
        node.undeclare_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM)


def override(value: bool | str) -> list[Parameter]:
    return [Parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, value=value)]


def test_the_parameter_may_say_no(make_node: MakeNode) -> None:
    assert offered(make_node('a', parameter_overrides=override(False))) == []


def test_an_override_that_is_no_bool_is_refused_and_leaves_no_node(make_node: MakeNode) -> None:
    with pytest.raises(InvalidParameterTypeException):
        make_node('a', parameter_overrides=override('yes'))
    assert make_node('b').get_node_names() == ['b']


def test_a_declared_override_that_is_no_bool_is_reported(
    make_node: MakeNode, capsys: pytest.CaptureFixture[str]
) -> None:
    node = make_node(
        'a', parameter_overrides=override('yes'), automatically_declare_parameters_from_overrides=True
    )
    assert offered(node) == []
    assert "Invalid type for parameter 'start_type_description_service'" in capsys.readouterr().err


def test_it_may_be_taken_away(make_node: MakeNode) -> None:
    node = make_node('a', parameter_overrides=override(False))
    service = TypeDescriptionService(node)
    assert not service.enabled
    service.destroy()
    node._type_description_service.destroy()
    other = make_node('b')
    other._type_description_service.destroy()
    other._type_description_service.destroy()
    assert offered(other) == []
