"""Parameters of another node: the six services, /parameter_events, and rclpy's two helpers for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterEvent,
    ParameterValue,
    SetParametersResult,
)
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.parameter_event_handler import ParameterEventHandler

from goalwire.idl import type_name

FINE = SetParametersResult(successful=True)


@pytest.fixture
def owner(make_node: MakeNode, spin: Spin) -> Node:
    """A spun node, /ns/owner, with parameters."""
    node = make_node('owner', namespace='ns')
    node.declare_parameters('', [('a', 1), ('g.h', 'x'), ('typed', Parameter.Type.INTEGER)])
    node.declare_parameter('dyn', 1, ParameterDescriptor(dynamic_typing=True))
    node.declare_parameter('ro', 1, ParameterDescriptor(read_only=True))
    spin(node)
    return node


@pytest.fixture
def asker(make_node: MakeNode, spin: Spin) -> Node:
    node = make_node('asker', namespace='ns')
    spin(node)
    return node


@pytest.fixture
def client(owner: Node, asker: Node) -> AsyncParameterClient:
    client = AsyncParameterClient(asker, '/ns/owner')
    assert client.wait_for_services(PATIENCE)
    return client


def refusal(reason: str) -> SetParametersResult:
    return SetParametersResult(successful=False, reason=reason)


# -- services ------------------------------------------------------------------------------------------------


def test_a_node_offers_six_services_with_ros_2_s_qos(make_node: MakeNode) -> None:
    node = make_node('nn', namespace='ns')
    offered = [service for service in node.services if 'param' in service.service_name]
    assert [service.service_name for service in offered] == [
        '/ns/nn/describe_parameters',
        '/ns/nn/get_parameters',
        '/ns/nn/get_parameter_types',
        '/ns/nn/list_parameters',
        '/ns/nn/set_parameters',
        '/ns/nn/set_parameters_atomically',
    ]
    assert {service.qos_profile.depth for service in offered} == {1000}
    assert {service.callback_group for service in offered} == {node.default_callback_group}
    assert type_name(offered[0].srv_type) == 'rcl_interfaces/srv/DescribeParameters'


def test_without_parameter_services_there_are_none(make_node: MakeNode) -> None:
    node = make_node(start_parameter_services=False)
    assert not [service for service in node.services if 'param' in service.service_name]


def test_values_are_got_all_or_none(client: AsyncParameterClient) -> None:
    values = result_of(client.get_parameters(['a', 'g.h'])).values
    assert [parameter_value_to_python(value) for value in values] == [1, 'x']
    for names in ([], ['nope'], ['a', 'nope'], ['a', 'typed']):
        assert result_of(client.get_parameters(names)).values == []


def test_types_and_descriptors_are_got_all_or_none(client: AsyncParameterClient) -> None:
    assert list(result_of(client.get_parameter_types(['a', 'g.h', 'typed'])).types) == [2, 4, 0]
    assert list(result_of(client.get_parameter_types(['a', 'nope'])).types) == []
    (a, typed, ro) = result_of(client.describe_parameters(['a', 'typed', 'ro'])).descriptors
    assert (a.name, a.type, typed.type, ro.read_only) == ('a', 2, 2, True)
    assert result_of(client.describe_parameters(['a', 'nope'])).descriptors == []


def test_types_of_undeclared_parameters_are_got_where_those_are_allowed(
    make_node: MakeNode, spin: Spin, asker: Node
) -> None:
    spin(make_node('free', allow_undeclared_parameters=True))
    client = AsyncParameterClient(asker, '/free')
    assert client.wait_for_services(PATIENCE)
    assert list(result_of(client.get_parameter_types(['nope', 'use_sim_time'])).types) == [0, 1]


def test_names_are_listed(client: AsyncParameterClient) -> None:
    listed = result_of(client.list_parameters()).result
    assert set(listed.names) >= {'a', 'g.h', 'typed', 'dyn', 'ro', 'use_sim_time'}
    assert result_of(client.list_parameters(['g'], 1)).result == ListParametersResult(
        names=['g.h'], prefixes=['g']
    )


def test_each_set_has_its_own_result(client: AsyncParameterClient, owner: Node) -> None:
    response = result_of(
        client.set_parameters(
            [
                Parameter('a', value=9),
                Parameter('a', value='s').to_parameter_msg(),
                Parameter('nope', value=1),
                Parameter('ro', value=1),
                ParameterMessage(name='a', value=ParameterValue(type=99)),
            ]
        )
    )
    assert response.results == [
        FINE,
        refusal("Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'"),
        refusal("Invalid access to undeclared parameter(s): ['nope']"),
        refusal('Trying to set a read-only parameter: ro.'),
        refusal("parameter 'a': 99 is not a valid Parameter.Type"),
    ]
    assert owner.get_parameter('a').value == 9


def test_an_atomic_set_has_one_result(client: AsyncParameterClient, owner: Node) -> None:
    both = [Parameter('a', value=11), Parameter('g.h', value='y')]
    assert result_of(client.set_parameters_atomically(both)).result == FINE
    bad = [Parameter('a', value=12), Parameter('nope', value=3)]
    assert not result_of(client.set_parameters_atomically(bad)).result.successful
    assert owner.get_parameter('a').value == 11


def test_only_dynamically_typed_parameters_are_deleted(client: AsyncParameterClient, owner: Node) -> None:
    assert result_of(client.delete_parameters(['a', 'dyn'])).results == [
        refusal('Static parameter cannot be undeclared'),
        FINE,
    ]
    assert not owner.has_parameter('dyn')


def test_a_callback_gets_the_future(client: AsyncParameterClient) -> None:
    done: Collector[Any] = Collector()
    future = client.get_parameters(['a'], callback=done)
    assert done.expect() == [future]


def test_a_file_is_loaded_whatever_nodes_it_names(
    client: AsyncParameterClient, owner: Node, tmp_path: Path
) -> None:
    file = tmp_path / 'p.yaml'
    file.write_text('other:\n  ros__parameters: {a: 22, g: {h: "1"}}\n/**:\n  ros__parameters: {dyn: 5}\n')
    assert result_of(client.load_parameter_file(str(file))).results == [FINE, FINE]
    assert [owner.get_parameter(name).value for name in ('a', 'g.h', 'dyn')] == [22, '1', 1]
    assert result_of(client.load_parameter_file_atomically(str(file), True)).result == FINE
    assert owner.get_parameter('dyn').value == 5
    with pytest.raises(FileNotFoundError):
        _ = client.load_parameter_file(str(tmp_path / 'nope'))


def test_waiting_for_services_ends(asker: Node, owner: Node) -> None:
    assert AsyncParameterClient(asker, 'owner').wait_for_services(PATIENCE)  # relative to the namespace
    absent = AsyncParameterClient(asker, '/none')
    assert not absent.services_are_ready()
    assert not absent.wait_for_services(0.01)


def test_services_wait_for_a_callback_of_the_default_group_to_end(
    owner: Node, client: AsyncParameterClient
) -> None:
    began: Collector[None] = Collector()
    going_on: Collector[None] = Collector()

    def busy() -> None:
        began(None)
        going_on.expect(1, PATIENCE)

    timer = owner.create_timer(0.0, busy)
    began.expect(1, PATIENCE)
    future = client.get_parameters(['a'])
    assert not future.done()
    timer.cancel()
    going_on(None)
    assert result_of(future).values[0].integer_value == 1


def test_a_node_may_ask_another_from_within_a_callback(asker: Node, client: AsyncParameterClient) -> None:
    found: Collector[object] = Collector()
    getter = asker.create_client(GetParameters, '/ns/owner/get_parameters')

    def ask() -> None:
        if client.wait_for_services(PATIENCE):
            found(getter.call(GetParameters.Request(names=['a']), PATIENCE))

    asker.create_guard_condition(ask).trigger()
    assert found.expect() == [GetParameters.Response(values=[Parameter('a', value=1).get_parameter_value()])]


# -- events --------------------------------------------------------------------------------------------------


class Events:
    """The events of one node, heard on /parameter_events, each as (new, changed, deleted) names."""

    def __init__(self, context: Context, listener: Node, owner: Node) -> None:
        self.collected: Collector[ParameterEvent] = Collector()
        self._taken = 0
        listener.create_subscription(ParameterEvent, '/parameter_events', self.collected, 1000)
        wait_until(context, lambda: next(owner.publishers).get_subscription_count() == 1)

    def next(self) -> tuple[list[str], ...]:
        self._taken += 1
        event = self.collected.expect(self._taken, PATIENCE)[self._taken - 1]
        return tuple(
            [parameter.name for parameter in kind]
            for kind in (event.new_parameters, event.changed_parameters, event.deleted_parameters)
        )


@pytest.fixture
def events(context: Context, owner: Node, asker: Node) -> Events:
    return Events(context, asker, owner)


def test_an_event_tells_who_when_and_what(owner: Node, events: Events) -> None:
    before = owner.get_clock().now()
    owner.declare_parameter('n', 5)
    (event,) = events.collected.expect(1, PATIENCE)
    assert event.node == '/ns/owner'
    assert event.new_parameters == [Parameter('n', value=5).to_parameter_msg()]
    assert before.to_msg().sec <= event.stamp.sec <= owner.get_clock().now().to_msg().sec


def test_each_change_is_an_event(owner: Node, events: Events) -> None:
    owner.declare_parameters('', [('b', 2), ('c', 3)])
    assert (events.next(), events.next()) == ((['b'], [], []), (['c'], [], []))
    owner.set_parameters([Parameter('a', value=1), Parameter('b', value=4)])
    assert (events.next(), events.next()) == (([], ['a'], []), ([], ['b'], []))
    owner.set_parameters_atomically([Parameter('a', value=5), Parameter('typed', value=6)])
    assert events.next() == (['typed'], ['a'], [])
    owner.set_parameters([Parameter('dyn')])
    assert events.next() == ([], [], ['dyn'])


def test_what_changes_nothing_is_no_event(owner: Node, events: Events) -> None:
    owner.set_parameters([Parameter('a', value='bad')])
    owner.set_parameters_atomically([])
    owner.undeclare_parameter('a')
    owner.declare_parameter('last', 1)
    assert events.next() == (['last'], [], [])


def test_a_new_node_announces_its_standing_parameters(events: Events, make_node: MakeNode) -> None:
    make_node('fresh')
    assert events.next()[0] == ['use_sim_time']
    assert events.collected.items[0].node == '/fresh'


def test_the_publisher_of_events_is_listed_with_ros_2_s_qos(owner: Node) -> None:
    (publisher,) = owner.publishers
    assert (publisher.topic_name, publisher.qos_profile.depth) == ('/parameter_events', 1000)
    assert type_name(publisher.msg_type) == 'rcl_interfaces/msg/ParameterEvent'


def test_a_client_subscribes_to_events(context: Context, client: AsyncParameterClient, owner: Node) -> None:
    heard: Collector[ParameterEvent] = Collector()
    client.on_parameter_event(heard)
    wait_until(context, lambda: next(owner.publishers).get_subscription_count() == 1)
    owner.set_parameters([Parameter('a', value=3)])
    assert heard.expect()[0].changed_parameters[0].name == 'a'


# -- handlers ------------------------------------------------------------------------------------------------


@pytest.fixture
def handler(context: Context, owner: Node, asker: Node) -> ParameterEventHandler:
    handler = ParameterEventHandler(asker)
    for node in (owner, asker):
        wait_until(context, lambda node=node: next(node.publishers).get_subscription_count() == 1)  # type: ignore[misc]
    return handler


def test_parameter_callbacks_come_before_event_callbacks_the_last_added_first(
    owner: Node, handler: ParameterEventHandler
) -> None:
    heard: Collector[object] = Collector()
    handler.add_parameter_event_callback(lambda event: heard(('event', event.node)))
    handler.add_parameter_callback('a', '/ns/owner', lambda found: heard(('a1', found.value.integer_value)))
    handler.add_parameter_callback('a', 'owner', lambda found: heard(('a2', type(found).__name__)))
    handler.add_parameter_callback('a', '/other', lambda _: heard('wrong node'))
    handler.add_parameter_callback('b', '/ns/owner', lambda _: heard('wrong name'))
    owner.set_parameters([Parameter('a', value=50)])
    assert heard.expect(3, PATIENCE) == [('a2', 'Parameter'), ('a1', 50), ('event', '/ns/owner')]


@pytest.mark.parametrize('own', ['', None, 'asker', '/ns/asker'])
def test_a_node_listens_to_itself(asker: Node, handler: ParameterEventHandler, own: Any) -> None:
    heard: Collector[int] = Collector()
    handle = handler.add_parameter_callback('mine', own, lambda found: heard(found.value.integer_value))
    assert (handle.parameter_name, handle.node_name) == ('mine', '/ns/asker')
    asker.declare_parameter('mine', 7)
    assert heard.expect() == [7]


def test_callbacks_are_removed_once(owner: Node, handler: ParameterEventHandler) -> None:
    heard: Collector[str] = Collector()
    parameter = handler.add_parameter_callback('a', '/ns/owner', lambda _: heard('removed'))
    event = handler.add_parameter_event_callback(lambda _: heard('removed'))
    handler.add_parameter_event_callback(lambda _: heard('stays'))
    handler.remove_parameter_callback(parameter)
    handler.remove_parameter_event_callback(event)
    with pytest.raises(RuntimeError, match=r"^Callback doesn't exist$"):
        handler.remove_parameter_callback(parameter)
    with pytest.raises(RuntimeError, match=r"^Callback doesn't exist$"):
        handler.remove_parameter_event_callback(event)
    owner.set_parameters([Parameter('a', value=50)])
    assert heard.expect() == ['stays']
    handler.destroy()
    handler.destroy()


def test_raw_events_reach_event_callbacks_as_they_are(context: Context, owner: Node, asker: Node) -> None:
    heard: Collector[object] = Collector()
    handler = ParameterEventHandler(asker, raw=True)
    handler.add_parameter_event_callback(lambda event: heard(type(event)))
    handler.add_parameter_callback('a', '/ns/owner', lambda found: heard(found.value.integer_value))
    wait_until(context, lambda: next(owner.publishers).get_subscription_count() == 1)
    owner.set_parameters([Parameter('a', value=50)])
    assert heard.expect(2, PATIENCE) == [50, bytes]


def test_parameters_are_found_in_an_event() -> None:
    def message(name: str) -> ParameterMessage:
        return Parameter(name, value=1).to_parameter_msg()

    event = ParameterEvent(
        node='/n',
        new_parameters=[message('new')],
        changed_parameters=[message('changed')],
        deleted_parameters=[message('deleted')],
    )
    find = ParameterEventHandler.get_parameter_from_event
    assert find(event, 'new', '/n') == message('new')
    assert find(event, 'changed', '/n') == message('changed')
    for name, node in (('deleted', '/n'), ('new', 'n'), ('new', '/other'), ('nope', '/n')):
        assert find(event, name, node) is None
    found = ParameterEventHandler.get_parameters_from_event(event)
    assert [parameter.name for parameter in found] == ['new', 'changed']
