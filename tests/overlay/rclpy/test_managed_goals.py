"""goalwire's additions to rclpy's actions: policies, clients that go, why a goal failed, cancelling many."""

from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time as StampMessage
from example_interfaces.action import Fibonacci
from helpers.actions import NAMES, Arena, Gate, Goal, Patient, Result, accept_cancel, id_of, succeed
from helpers.collector import Collector
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import ActionClient, ActionServer, GoalResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle

import goalwire
from goalwire.logging import add_sink
from goalwire.rules.goals.policy import GoalPolicy, OnClientLost


def managed(make_node: MakeNode, spin: Spin, patient: Patient, **options: Any) -> Arena:
    return Arena(make_node, spin, patient, cancel=accept_cancel, **options)


def last_status(arena: Arena, handle: ClientGoalHandle) -> str:
    return arena.result(handle)[0]


# -- policies ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(('policy', 'places'), [(goalwire.single(), 1), (goalwire.parallel(2), 2)])
def test_one_goal_too_many_is_refused(
    make_node: MakeNode, spin: Spin, policy: GoalPolicy, places: int
) -> None:
    patient = Patient()
    arena = managed(make_node, spin, patient, policy=policy)
    handles = [arena.accept(order) for order in range(places)]
    assert not arena.send(9).accepted
    patient.gate.open()
    assert [last_status(arena, handle) for handle in handles] == ['SUCCEEDED'] * places
    assert last_status(arena, arena.accept(9)) == 'SUCCEEDED'


def test_queued_goals_are_accepted_then_executing_and_one_of_them_is_cancelled(
    make_node: MakeNode, spin: Spin
) -> None:
    patient = Patient()
    arena = managed(make_node, spin, patient, policy=goalwire.queue(2))
    first = arena.accept(1)
    patient.wait_for(1)  # in a reentrant group another thread may take the second goal before this one's turn
    second, third = (arena.accept(order) for order in (2, 3))
    assert not arena.send(4).accepted
    assert arena.seen(third, 'ACCEPTED') == ['ACCEPTED']
    assert arena.cancel(second.goal_id) == (0, [bytes(second.goal_id.uuid)])
    assert last_status(arena, second) == 'CANCELED'
    patient.gate.open()
    assert [last_status(arena, handle) for handle in (first, third)] == ['SUCCEEDED'] * 2
    patient.wait_for(1, 3)
    assert arena.seen(third, 'SUCCEEDED') == ['ACCEPTED', 'EXECUTING', 'SUCCEEDED']
    assert arena.seen(second, 'CANCELED')[-1] == 'CANCELED'


def test_a_new_goal_asks_the_running_one_to_stop_and_follows_it(make_node: MakeNode, spin: Spin) -> None:
    patient = Patient()
    arena = Arena(make_node, spin, patient, policy=goalwire.preempt())  # asks no cancel callback
    first = arena.accept(1)
    patient.wait_for(1)
    second = arena.accept(2)
    arena.seen(first, 'CANCELING')
    assert patient.gate.reached.items[0].is_cancel_requested
    patient.gate.open()
    assert (last_status(arena, first), last_status(arena, second)) == ('CANCELED', 'SUCCEEDED')
    patient.wait_for(1, 2)


def test_a_deferred_goal_waits_for_its_turn_from_its_execution_on(make_node: MakeNode, spin: Spin) -> None:
    patient = Patient()
    deferred: Collector[ServerGoalHandle] = Collector()
    arena = managed(make_node, spin, patient, policy=goalwire.queue(1), accepted=deferred)
    handles = [arena.accept(order) for order in (1, 2)]
    one, two = sorted(deferred.expect(2), key=lambda handle: int(handle.request.order))
    for handle in (two, one, one):  # the last waits already: nothing new
        handle.execute()
    patient.wait_for(2)
    patient.gate.open()
    assert [last_status(arena, handle) for handle in handles] == ['SUCCEEDED'] * 2
    patient.wait_for(2, 1)


# -- failures ----------------------------------------------------------------------------------------------


def test_why_execution_failed_reaches_the_client_and_the_hook(make_node: MakeNode, spin: Spin) -> None:
    failures: list[str] = []

    def execute(_: ServerGoalHandle) -> Fibonacci.Result:
        raise OSError(5, 'no such joint')

    def note(handle: ServerGoalHandle, error: Exception) -> Fibonacci.Result:
        failures.append(f'{handle.request.order}: {error!r}')
        return Result(sequence=[7])

    arena = Arena(make_node, spin, execute, on_failure=note)
    lines = Collector[str]()
    handle = arena.accept(3)
    assert handle.reason == ''
    with add_sink(lambda record: lines(f'{record.severity.name} {record.name}: {record.message}')):
        for _ in range(2):
            assert arena.result(handle) == ('ABORTED', [7])
    assert handle.reason == 'OSError: [Errno 5] no such joint'
    told = f"Action 'fib': goal {id_of(handle).hex()} was aborted: {handle.reason}"
    assert [line for line in lines.items if 'was aborted' in line] == [f'WARN client.action_client: {told}']
    assert failures == ["3: OSError(5, 'no such joint')"]


def test_a_goal_that_was_reached_has_no_reason(make_node: MakeNode, spin: Spin) -> None:
    arena = Arena(make_node, spin, succeed)
    handle = arena.accept(3)
    lines = Collector[str]()
    with add_sink(lambda record: lines(record.message)):
        assert arena.result(handle) == ('SUCCEEDED', [3])
    assert handle.reason == ''
    assert lines.items == []


# -- cancelling many ---------------------------------------------------------------------------------------


def test_all_goals_are_cancelled_by_one_request(make_node: MakeNode, spin: Spin) -> None:
    patient = Patient()
    arena = managed(make_node, spin, patient)
    handles = [arena.accept(order) for order in (1, 2)]
    answer = result_of(arena.client.cancel_all_goals_async())
    assert answer.return_code == 0
    cancelled = {bytes(goal.goal_id.uuid) for goal in answer.goals_canceling}
    assert cancelled == {bytes(handle.goal_id.uuid) for handle in handles}
    patient.gate.open()
    assert [last_status(arena, handle) for handle in handles] == ['CANCELED'] * 2
    blocking = arena.client.cancel_all_goals()
    assert blocking is not None
    assert not blocking.goals_canceling


def test_goals_accepted_before_a_time_are_cancelled(make_node: MakeNode, spin: Spin) -> None:
    patient = Patient()
    arena = managed(make_node, spin, patient)
    before = arena.accept(1)
    between = arena.server_node.get_clock().now()
    later = arena.accept(2)
    for answer in (
        arena.client.cancel_goals_before(between),
        result_of(arena.client.cancel_goals_before_async(between.to_msg())),
    ):
        assert answer is not None
        cancelled = [bytes(goal.goal_id.uuid) for goal in answer.goals_canceling]
        assert cancelled in ([bytes(before.goal_id.uuid)], [])
    patient.gate.open()
    assert [last_status(arena, handle) for handle in (before, later)] == ['CANCELED', 'SUCCEEDED']
    with pytest.raises(ValueError, match='cancel_all_goals cancels all'):
        _ = arena.client.cancel_goals_before_async(StampMessage())
    no_time: Any = 3
    with pytest.raises(TypeError, match='a Time or a builtin_interfaces/msg/Time is needed, not 3'):
        _ = arena.client.cancel_goals_before_async(no_time)


# -- clients that go ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('choice', 'status', 'asked'), [('cancel', 'CANCELED', True), ('abort', 'ABORTED', False)]
)
def test_the_goals_of_a_client_that_has_gone_end_and_no_others(
    make_node: MakeNode, spin: Spin, choice: OnClientLost, status: str, asked: bool
) -> None:
    patient = Patient()
    arena = Arena(make_node, spin, patient, on_client_lost=choice)
    other = ActionClient(arena.client_node, Fibonacci, 'fib')
    kept = result_of(other.send_goal_async(Goal(order=2)))
    lost = arena.accept(1)
    patient.gate.reached.wait_for(lambda seen: len(seen) == 2)
    arena.client.destroy()
    arena.expect_event('on_client_lost')
    by_order = {handle.request.order: handle for handle in patient.gate.reached.items}
    assert by_order[1].is_cancel_requested is asked
    assert by_order[1].is_active is asked
    assert not by_order[2].is_cancel_requested
    patient.gate.open()
    assert NAMES[result_of(kept.get_result_async()).status] == 'SUCCEEDED'
    assert arena.seen(lost, status)[-1] == status


def test_a_goal_that_is_being_decided_when_its_client_goes_is_dropped(
    make_node: MakeNode, spin: Spin
) -> None:
    gate = Gate()
    executed: list[ServerGoalHandle] = []

    def decide(goal: Any) -> Any:
        gate(goal)
        return GoalResponse.ACCEPT

    arena = Arena(make_node, spin, executed.append, goal=decide, on_client_lost='cancel')
    _ = arena.client.send_goal_async(Goal(order=1))
    gate.reached.wait_for(bool)
    arena.client.destroy()
    arena.expect_event('on_client_lost')
    gate.open()
    arena.expect_event('on_goal_decision')
    assert arena.server.reactor.statistics().accepted == 0
    assert executed == []


def test_what_else_may_become_of_goals_is_refused(make_node: MakeNode) -> None:
    with pytest.raises(ValueError, match="'keep' or 'cancel' or 'abort', not 'forget'"):
        ActionServer(make_node('node'), Fibonacci, 'fib', succeed, on_client_lost='forget')  # type: ignore[arg-type]
