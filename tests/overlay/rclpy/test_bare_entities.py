"""Entities and wait sets of rclpy's C extension, with which programs wait for data themselves."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.context import Context
from rclpy.event_handler import QoSPublisherEventType
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerGuardCondition
from rclpy.time import Time
from rclpy.waitable import NumberOfEntities, Waitable
from std_msgs.msg import String
from std_srvs.srv import SetBool

LIMIT = int(PATIENCE * 1e9)
PROFILE = QoSProfile(depth=10).get_c_qos_profile()


@pytest.fixture
def node(make_node: MakeNode) -> Node:
    return make_node()


def wait_set_of(context: Context) -> Any:
    return _rclpy.WaitSet(1, 1, 1, 1, 1, 1, context.handle)


def in_a_thread(waits: Any) -> threading.Thread:
    """Start a thread that waits; return it when it has found nothing ready."""
    found_nothing = threading.Event()
    look = waits.look

    def note_look() -> None:
        look()
        found_nothing.set()

    waits.look = note_look
    thread = threading.Thread(target=waits.wait)
    thread.start()
    assert found_nothing.wait(PATIENCE)
    return thread


class Taker(Waitable[object]):
    """Waits for one bare entity of `kind`, and keeps what `take` returns."""

    def __init__(self, kind: str, entity: object, take: Any) -> None:
        super().__init__(ReentrantCallbackGroup())
        self.kind, self.bare, self.take_data = kind, entity, take  # type: ignore[method-assign]
        self.index = -1
        self.taken = threading.Event()
        self.data: object = None

    def get_num_entities(self) -> NumberOfEntities:
        return NumberOfEntities()

    def add_to_wait_set(self, wait_set: Any) -> None:
        self.index = getattr(wait_set, f'add_{self.kind}')(self.bare)

    def is_ready(self, wait_set: Any) -> bool:
        return bool(wait_set.is_ready(self.kind, self.index))

    async def execute(self, taken_data: object) -> None:
        self.data = taken_data
        self.taken.set()


def test_a_waitable_takes_what_a_bare_subscription_keeps(node: Node, spin: Spin) -> None:
    with node.handle as handle:
        bare = _rclpy.Subscription(handle, String, 'topic', PROFILE)
    waitable = Taker('subscription', bare, lambda: bare.take_message(String, False))
    node.add_waitable(waitable)
    spin(node)
    publisher = node.create_publisher(String, 'topic', 10)
    wait_until(node.context, lambda: bare.publisher_count() == 1)
    publisher.publish(String(data='kept'))
    assert waitable.taken.wait(PATIENCE)
    data: Any = waitable.data
    assert data[0] == String(data='kept')


def test_no_executor_takes_from_a_bare_service(node: Node, spin: Spin) -> None:
    bare = _rclpy.Service(node.handle, SetBool, 'switch', PROFILE)
    client = node.create_client(SetBool, 'switch')
    spin(node)
    assert client.wait_for_service(PATIENCE)
    answer = client.call_async(SetBool.Request(data=True))
    waits = wait_set_of(node.context)
    index = waits.add_service(bare)
    waits.wait(LIMIT)
    assert waits.is_ready('service', index)
    request, header = bare.service_take_request(SetBool.Request)
    assert header is not None
    assert request is not None
    assert request.data
    assert bare.service_take_request(SetBool.Request) == (None, None)
    bare.service_send_response(SetBool.Response(message='on'), header)
    assert result_of(answer).message == 'on'


def test_a_bare_client_gives_each_response_with_its_number(node: Node, spin: Spin) -> None:
    def echo(request: Any, response: Any) -> Any:
        response.success = request.data
        return response

    node.create_service(SetBool, 'switch', echo)
    spin(node)
    bare = _rclpy.Client(node.handle, SetBool, 'switch', PROFILE)
    wait_until(node.context, bare.service_server_is_available)
    assert bare.take_response(SetBool.Response) == (None, None)
    sent = {bare.send_request(SetBool.Request(data=value)): value for value in (True, False)}
    got: dict[int, bool] = {}
    waits = wait_set_of(node.context)
    while len(got) < 2:
        waits.clear_entities()
        index = waits.add_client(bare)
        waits.wait(LIMIT)
        assert waits.is_ready('client', index)
        while (taken := bare.take_response(SetBool.Response))[0] is not None:
            header, response = taken
            got[header.request_id.sequence_number] = response.success
    assert got == sent


def test_a_bare_client_is_ready_while_responses_wait(node: Node, spin: Spin) -> None:
    node.create_service(SetBool, 'switch', lambda _, response: response)
    spin(node)
    bare = _rclpy.Client(node.handle, SetBool, 'switch', PROFILE)
    wait_until(node.context, bare.service_server_is_available)
    for _ in range(2):
        bare.send_request(SetBool.Request())
    for _, call in bare._calls:
        result_of(call)
    for is_ready in (True, True, False):
        waits = wait_set_of(node.context)  # rclpy's executors make one for each wait
        index = waits.add_client(bare)
        waits.wait(0)
        assert waits.is_ready('client', index) == is_ready
        assert (bare.take_response(SetBool.Response)[0] is not None) == is_ready


def test_a_response_that_comes_while_its_request_is_sent_is_taken(node: Node, spin: Spin) -> None:
    node.create_service(SetBool, 'switch', lambda _, response: response)
    spin(node)
    bare = _rclpy.Client(node.handle, SetBool, 'switch', PROFILE)
    wait_until(node.context, bare.service_server_is_available)
    begin, taken = bare.begin, []
    taker = threading.Thread(target=lambda: taken.append(bare.take_response(SetBool.Response)))

    def begin_slowly(request: Any, timeout: float | None) -> Any:
        call = begin(request, timeout)
        result_of(call)
        taker.start()
        taker.join(0.1)
        return call

    bare.begin = begin_slowly  # type: ignore[method-assign]
    bare.send_request(SetBool.Request())
    taker.join(PATIENCE)
    ((_, response),) = taken
    assert response == SetBool.Response()


def test_a_bare_guard_condition_wakes_a_wait_set_and_a_waitable(node: Node, spin: Spin) -> None:
    with node.context.handle as handle:
        bare = _rclpy.GuardCondition(handle)
    waits = wait_set_of(node.context)
    index = waits.add_guard_condition(bare)
    waits.wait(0)
    assert not waits.is_ready('guard_condition', index)
    thread = in_a_thread(waits)
    bare.trigger_guard_condition()
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert waits.get_ready_entities('guard_condition') == [bare.pointer]
    waitable = Taker('guard_condition', bare, lambda: 'triggered')
    node.add_waitable(waitable)
    spin(node)
    bare.trigger_guard_condition()
    assert waitable.taken.wait(PATIENCE)
    bare.destroy_when_not_in_use()
    with pytest.raises(InvalidHandle), bare:
        pass


def test_a_trigger_of_a_bare_guard_condition_is_for_one_wait(context: Context) -> None:
    bare = _rclpy.GuardCondition(context.handle)
    bare.trigger_guard_condition()
    for is_ready in (True, False):
        waits = wait_set_of(context)  # rclpy's executors make one for each wait
        index = waits.add_guard_condition(bare)
        waits.wait(0)
        assert waits.is_ready('guard_condition', index) == is_ready
    bare.trigger_guard_condition()
    waits.wait(LIMIT)
    assert waits.is_ready('guard_condition', index)
    bare.destroy()


def test_a_wait_set_wakes_for_each_call_of_a_bare_timer(context: Context) -> None:
    bare = _rclpy.Timer(Clock(clock_type=ClockType.STEADY_TIME).handle, context.handle, 1_000_000, True)
    waits = wait_set_of(context)
    index = waits.add_timer(bare)
    for _ in range(3):
        waits.wait(LIMIT)
        assert waits.is_ready('timer', index)
        bare.call_timer()
        waits.wait(0)
    bare.destroy()


def test_a_wait_set_wakes_when_the_program_sets_the_time(context: Context) -> None:
    clock = ROSClock()
    clock.set_ros_time_override(Time(seconds=1, clock_type=ClockType.ROS_TIME))
    clock._set_ros_time_is_active(True)
    bare = _rclpy.Timer(clock.handle, context.handle, 10**9, True)
    waits = wait_set_of(context)
    waits.add_timer(bare)
    thread = in_a_thread(waits)
    clock.set_ros_time_override(Time(seconds=2, clock_type=ClockType.ROS_TIME))
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert waits.get_ready_entities('timer') == [bare.pointer]
    bare.destroy()


def test_matches_of_a_publisher_are_taken_from_an_event_handle(node: Node) -> None:
    publisher = node.create_publisher(String, 'topic', 10)
    with publisher.handle as handle:
        event = _rclpy.EventHandle(handle, QoSPublisherEventType.RCL_PUBLISHER_MATCHED)
    waits = wait_set_of(node.context)
    index = waits.add_event(event)
    waits.wait(0)
    assert not waits.is_ready('event', index)
    subscription = node.create_subscription(String, 'topic', print, 10)
    for total_change, change, act in ((1, 1, subscription.destroy), (0, -1, event.destroy_when_not_in_use)):
        waits.wait(LIMIT)
        assert waits.is_ready('event', index)
        status: Any = event.take_event()
        assert (status.total_count, status.total_count_change) == (1, total_change)
        assert status.current_count_change == change
        unchanged: Any = event.take_event()
        assert (unchanged.total_count, unchanged.total_count_change) == (1, 0)
        act()
    assert event.destroyed


def test_a_message_is_awaited_as_rclpy_itself_does(make_node: MakeNode, node: Node) -> None:
    """Many programs have a copy of rclpy's own function, from the time when it was new."""
    subscription = node.create_subscription(String, 'topic', print, 1)
    guard = SignalHandlerGuardCondition(node.context)
    publisher = make_node().create_publisher(String, 'topic', 1)
    wait_until(node.context, lambda: subscription.get_publisher_count() == 1)
    publisher.publish(String(data='come'))
    waits = wait_set_of(node.context)
    waits.clear_entities()
    waits.add_subscription(subscription.handle)
    waits.add_guard_condition(guard.handle)
    waits.wait(LIMIT)
    handles: Any = subscription.handle, guard.handle
    assert waits.get_ready_entities('subscription') == [handles[0].pointer]
    assert handles[1].pointer not in waits.get_ready_entities('guard_condition')
    taken = subscription.handle.take_message(String, False)
    assert taken is not None
    assert taken[0] == String(data='come')
    assert subscription.event_queue.watchers == ()
    guard.destroy()


def test_a_wait_ends_with_its_time_and_with_the_context(context: Context) -> None:
    waits = wait_set_of(context)
    waits.wait(1)
    bare = _rclpy.GuardCondition(context.handle)
    waits.add_guard_condition(bare)
    thread = in_a_thread(waits)
    context.shutdown()
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert bare.watchers == ()
    assert waits.get_ready_entities('guard_condition') == []
    with pytest.raises(RuntimeError, match="'guard' is not a known entity"):
        waits.get_ready_entities('guard')
