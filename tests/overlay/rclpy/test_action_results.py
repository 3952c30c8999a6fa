"""Ids and results of goals, how long they are kept, and the status array that shows them."""

from __future__ import annotations

import threading

from action_msgs.msg import GoalStatusArray
from builtin_interfaces.msg import Time
from example_interfaces.action import Fibonacci
from helpers.actions import (
    NAMES,
    Arena,
    Gate,
    succeed,
)
from helpers.collector import Collector
from helpers.spinning import PATIENCE, MakeNode, Spin, result_of
from rclpy.action.server import ServerGoalHandle
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_action_status_default
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
