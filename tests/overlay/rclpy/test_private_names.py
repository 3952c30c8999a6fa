"""Names of rclpy that begin with an underscore, and that programs and tools read all the same."""

from __future__ import annotations

from threading import Event
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.actions import Arena, succeed
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin
from rcl_interfaces.msg import ParameterEvent, SetParametersResult
from rclpy import _rclpy_pybind11
from rclpy.action import ActionServer
from rclpy.context import Context
from rclpy.executors import ShutdownException, TimeoutException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_event_handler import ParameterEventHandler
from rclpy.publisher import Publisher
from rclpy.qos import QoSPolicyKind, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from rclpy.qos_overriding_options import (
    QoSOverridingOptions,
    _declare_qos_parameters,
    _get_qos_policy_parameter,
)
from rclpy.subscription import Subscription
from rclpy.task import Future
from rclpy.time_source import TimeSource
from std_msgs.msg import String
from std_srvs.srv import SetBool

from goalwire.execution.wait_sets.waitable import watch


@pytest.fixture
def transport_name() -> str:
    """The memory transport alone: these tests are the same on every wire."""
    return 'goalwire_memory'


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node()


def test_an_action_server_lists_the_goals_that_it_keeps(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    server: Any = arena.server
    assert server._goal_handles == {}
    goal = arena.accept(3)
    arena.result(goal)
    assert list(server._goal_handles) == [bytes(goal.goal_id.uuid)]


def test_a_node_lists_the_callbacks_of_its_parameters(node: Any) -> None:
    def accept(_: list[Parameter]) -> SetParametersResult:
        return SetParametersResult(successful=True)

    for kind in ('pre', 'on', 'post'):
        getattr(node, f'add_{kind}_set_parameters_callback')(accept)
        assert accept in getattr(node, f'_{kind}_set_parameters_callbacks')
        getattr(node, f'remove_{kind}_set_parameters_callback')(accept)
        assert accept not in getattr(node, f'_{kind}_set_parameters_callbacks')


def test_a_parameter_event_handler_lists_its_callbacks_the_last_one_first(node: Node) -> None:
    handler = ParameterEventHandler(node)
    events: list[object] = []
    first, second = (handler.add_parameter_event_callback(events.append) for _ in range(2))
    speed = handler.add_parameter_callback('speed', 'arm', events.append)
    callbacks: Any = handler._callbacks
    assert callbacks.event_callbacks == [second, first]
    assert callbacks.parameter_callbacks == {('speed', '/arm'): [speed]}
    callbacks.event_callback(
        ParameterEvent(node='/arm', new_parameters=[Parameter('speed', value=3).to_parameter_msg()])
    )
    assert len(events) == 3
    handler.remove_parameter_callback(speed)
    assert callbacks.parameter_callbacks == {}


def test_a_parameter_event_handler_completes_names_of_nodes(make_node: MakeNode) -> None:
    handler = ParameterEventHandler(make_node('hand', namespace='/left'))
    names = [handler._resolve_path(*path) for path in ((), ('arm',), ('/arm',))]
    assert names == ['/left/hand', '/left/arm', '/arm']


def test_a_time_source_has_a_subscription_while_time_is_simulated(node: Node) -> None:
    source = TimeSource(node=node)
    assert source._clock_sub is None
    node.set_parameters([Parameter('use_sim_time', value=True)])
    assert source._clock_sub is not None


def test_a_subscription_says_what_its_callback_gets(node: Node) -> None:
    for callback, kind in (
        (lambda _: None, Subscription.CallbackType.MessageOnly),
        (lambda _message, _info: None, Subscription.CallbackType.WithMessageInfo),
    ):
        subscription: Any = node.create_subscription(String, 'topic', callback, 10)
        assert subscription._callback_type is kind


def test_a_profile_survives_the_form_of_the_c_layer() -> None:
    made = QoSProfile(**qos_profile_sensor_data.get_c_qos_profile().to_dict())  # type: ignore[arg-type]
    assert made == qos_profile_sensor_data
    profile_of_c = _rclpy_pybind11.rmw_qos_profile_t
    assert profile_of_c.predefined('qos_profile_sensor_data') == qos_profile_sensor_data.to_core()
    with pytest.raises(ValueError, match="no predefined QoS profile 'qos_profile_mine'"):
        profile_of_c.predefined('qos_profile_mine')


def test_the_parameters_of_a_profile_are_declared_for_a_kind_of_endpoint(make_node: MakeNode) -> None:
    override = Parameter('qos_overrides./scan.publisher.reliability', value='best_effort')
    node, profile = make_node(parameter_overrides=[override]), QoSProfile(depth=7)
    options = QoSOverridingOptions.with_default_policies()
    _declare_qos_parameters(Publisher, node, '/scan', profile, options)
    assert node.get_parameter('qos_overrides./scan.publisher.depth').value == 7
    assert profile.reliability is ReliabilityPolicy.BEST_EFFORT
    assert _get_qos_policy_parameter(profile, QoSPolicyKind.RELIABILITY) == 'best_effort'
    with pytest.raises(TypeError, match='should be a subclass of Publisher or Subscription'):
        _declare_qos_parameters(str, node, '/scan', profile, options)


def test_a_request_that_is_taken_by_hand_says_when_it_was_sent(node: Node) -> None:
    service = node.create_service(SetBool, 'switch', lambda _, response: response)
    assert service.handle.service_take_request(SetBool.Request) == (None, None)
    client = node.create_client(SetBool, 'switch')
    assert client.wait_for_service(PATIENCE)
    before = node.get_clock().now().nanoseconds
    has_come = Event()
    watch(service.event_queue, has_come.set)
    sent = client.call_async(SetBool.Request(data=True))
    assert has_come.wait(PATIENCE)
    request, header = service.handle.service_take_request(SetBool.Request)
    assert request is not None
    assert header is not None
    assert request.data
    assert before <= header.source_timestamp <= header.received_timestamp
    sent.cancel()


def test_an_executor_makes_futures_and_tells_whether_it_spins(node: Node, executor: Any) -> None:
    seen: Collector[bool] = Collector()
    assert not executor.is_spinning
    future = executor.create_future()
    future.add_done_callback(lambda _: seen(executor.is_spinning))
    future.set_result('done')
    assert seen.items == []
    executor.spin_once(timeout_sec=PATIENCE)
    assert seen.expect() == [True]


def test_a_future_names_its_executor(node: Node, executor: Any) -> None:
    class Own:
        """An executor that rclpy knows nothing of."""

        def create_task(self, callback: Any, *args: object) -> None:
            callback(*args)

    own = Own()
    made = [executor.create_future(), executor.create_task(bool)]
    futures: list[Any] = [*made, Future(executor=own), Future()]
    assert [future._executor() for future in futures] == [executor, executor, own, None]
    client = node.create_client(SetBool, 'switch')
    futures = [client.call_async(SetBool.Request())]
    assert futures[0]._executor() is None
    executor.add_node(node)
    assert futures[0]._executor() is executor


def test_an_executor_yields_ready_work_piece_by_piece(context: Context, executor: Any) -> None:
    done: list[str] = []
    for word in ('first', 'second'):
        executor.create_task(done.append, word)
    ready = executor._wait_for_ready_callbacks(timeout_sec=0)
    for _ in range(2):
        task, entity, node = next(ready)
        assert entity is node is None
        task()
    assert done == ['first', 'second']
    with pytest.raises(TimeoutException):
        next(ready)
    ready = executor._wait_for_ready_callbacks()
    executor.shutdown()
    with pytest.raises(ShutdownException):
        next(ready)


def test_goals_of_a_server_without_an_execute_callback_are_ended_by_the_program(
    make_node: MakeNode, spin: Spin
) -> None:
    arena = Arena(make_node, spin, succeed)
    arena.server.destroy()
    kept: Collector[Any] = Collector()

    def accept(handle: Any) -> None:
        handle.executing()
        kept(handle)

    server = ActionServer(arena.server_node, Fibonacci, arena.server.name, handle_accepted_callback=accept)
    goal = arena.accept(3)
    (kept_handle,) = kept.expect()
    assert kept_handle.is_active
    kept_handle.succeed(Fibonacci.Result(sequence=[1, 2]))
    assert arena.result(goal) == ('SUCCEEDED', [1, 2])
    server.destroy()
