"""Ids and results of goals, how long they are kept, and the status array that shows them."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from action_msgs.msg import GoalStatusArray
from builtin_interfaces.msg import Time
from example_interfaces.action import Fibonacci
from helpers.actions import (
    NAMES,
    Arena,
    Gate,
    id_of,
    succeed,
)
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.action.server import ServerGoalHandle
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_action_status_default, qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from rosgraph_msgs.msg import Clock
from unique_identifier_msgs.msg import UUID

Handle = ServerGoalHandle


def test_an_id_is_taken_until_its_result_is_forgotten(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    goal_id = UUID(uuid=[1] * 16)
    handle = arena.accept(5, goal_id)
    assert bytes(handle.goal_id.uuid) == b'\x01' * 16
    assert arena.result(handle) == ('SUCCEEDED', [5])
    again = arena.send(6, goal_id)
    assert not again.accepted
    assert again.stamp == Time()
    assert arena.result(handle) == ('SUCCEEDED', [5])


def test_a_result_is_handed_out_again_and_again(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    handle = arena.accept(2)
    results = [handle.get_result_async() for _ in range(3)]
    assert [list(result_of(result).result.sequence) for result in results] == [[2]] * 3
    assert arena.result(handle) == ('SUCCEEDED', [2])


def test_results_are_kept_for_their_time(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed, result_timeout=0.3)
    handle = arena.accept(2)
    assert arena.result(handle) == ('SUCCEEDED', [2])
    assert arena.result(handle) == ('SUCCEEDED', [2])
    forgotten = threading.Event()
    arena.server_node.create_timer(0.35, forgotten.set)
    assert forgotten.wait(PATIENCE)
    assert arena.result(handle) == ('UNKNOWN', [])
    assert arena.server.reactor.statistics().retained == 0


def test_simulated_time_stamps_goals_and_ends_the_keeping_of_results(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed, result_timeout=10)
    arena.server_node.set_parameters([Parameter('use_sim_time', value=True)])
    source = arena.server_node._time_source
    source.clock_callback(Clock(clock=Time(sec=100)))
    handle = arena.accept(2)
    assert handle.stamp == Time(sec=100)
    assert arena.result(handle) == ('SUCCEEDED', [2])
    source.clock_callback(Clock(clock=Time(sec=109)))
    assert arena.result(handle) == ('SUCCEEDED', [2])
    source.clock_callback(Clock(clock=Time(sec=111)))
    arena.expect_event('on_time')
    assert arena.server.reactor.statistics().retained == 0
    assert arena.result(handle) == ('UNKNOWN', [])


def test_with_no_time_to_keep_results_who_waits_still_gets_one(make_node: MakeNode, spin: Spin) -> None:
    gate = Gate()

    def execute(handle: Handle) -> Fibonacci.Result:
        gate(handle)
        return succeed(handle)

    arena = Arena(make_node, spin, execute, result_timeout=0)
    handle = arena.accept(2)
    first = handle.get_result_async()
    arena.expect_event('on_result_request')
    gate.open()
    assert list(result_of(first).result.sequence) == [2]
    assert arena.seen(handle, 'SUCCEEDED')[-1] == 'SUCCEEDED'
    assert arena.result(handle) == ('UNKNOWN', [])


def test_a_negative_time_keeps_results_for_ever(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed, result_timeout=-1)
    assert arena.result(arena.accept(2)) == ('SUCCEEDED', [2])
    assert arena.server._alarm.due is None


def test_the_status_array_holds_every_goal_in_order_of_acceptance(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    handles = [arena.accept(order) for order in range(4)]
    for handle in handles:
        arena.result(handle)
        arena.seen(handle, 'SUCCEEDED')
    last = arena.statuses.items[-1].status_list
    assert [bytes(entry.goal_info.goal_id.uuid) for entry in last] == [
        bytes(handle.goal_id.uuid) for handle in handles
    ]
    assert {NAMES[entry.status] for entry in last} == {'SUCCEEDED'}
    stamps = [(entry.goal_info.stamp.sec, entry.goal_info.stamp.nanosec) for entry in last]
    assert stamps == sorted(stamps)
    assert stamps[0] > (1_000_000_000, 0)


def test_who_comes_late_sees_the_statuses(make_node: MakeNode, spin: Spin) -> None:
    arena, late = Arena(make_node, spin, succeed), Collector[GoalStatusArray]()
    handle = arena.accept()
    arena.result(handle)
    arena.observer.create_subscription(
        GoalStatusArray, 'fib/_action/status', late, qos_profile_action_status_default
    )
    late.wait_for(lambda arrays: bool(arrays) and NAMES[arrays[-1].status_list[0].status] == 'SUCCEEDED')


# -- whoever asks ------------------------------------------------------------------------------------------


@pytest.mark.also_on_dds
def test_a_plain_client_reads_the_result_of_an_aborted_goal(make_node: MakeNode, spin: Spin) -> None:
    """The reason follows the message: see docs/adr/009. Service events show what the client reads."""

    def fail(_: Handle) -> Fibonacci.Result:
        raise OSError(5, 'no such joint' * 7)

    service = Fibonacci.Impl.GetResultService
    arena = Arena(make_node, spin, fail)
    events: Collector[Any] = Collector()
    arena.observer.create_subscription(service.Event, '/fib/_action/get_result/_service_event', events, 100)
    asker = make_node('asker')
    plain = asker.create_client(service, 'fib/_action/get_result')
    plain.configure_introspection(
        asker.get_clock(), qos_profile_system_default, ServiceIntrospectionState.CONTENTS
    )
    context = asker.context
    topic = '/fib/_action/get_result/_service_event'
    wait_until(context, lambda: arena.observer.count_publishers(topic) == 1)
    assert plain.wait_for_service(PATIENCE)
    handle = arena.accept(3)
    answer = result_of(plain.call_async(service.Request(goal_id=handle.goal_id)))
    assert (NAMES[answer.status], list(answer.result.sequence)) == ('ABORTED', [])
    assert arena.result(handle) == ('ABORTED', [])
    assert 'no such joint' in handle.reason
    sent, received = events.expect(2)
    assert bytes(sent.request[0].goal_id.uuid) == id_of(handle)
    assert NAMES[received.response[0].status] == 'ABORTED'


def test_rclpys_own_names_for_results_and_cancelling(make_node: MakeNode, spin: Spin) -> None:
    gate = Gate()
    arena = Arena(make_node, spin, gate)
    handle = arena.accept(3)
    client = arena.client
    answer = client._cancel_goal(handle)
    assert answer is not None
    assert answer == result_of(client._cancel_goal_async(handle))
    assert answer.goals_canceling == []  # this server refuses
    gate.open()
    result = client._get_result(handle)
    assert result is not None
    assert result == result_of(client._get_result_async(handle))
    for ask in (client._get_result, client._get_result_async, client._cancel_goal, client._cancel_goal_async):
        with pytest.raises(TypeError, match='Expected type ClientGoalHandle but received'):
            ask(handle.goal_id)  # type: ignore[arg-type]
