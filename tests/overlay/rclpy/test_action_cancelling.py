"""Cancelling goals, in all its forms."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from example_interfaces.action import Fibonacci
from helpers.actions import NAMES, NO_ID, Arena, Gate, Patient, Result, accept_cancel, id_of, succeed
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import CancelResponse
from rclpy.action.client import ClientGoalHandle
from rclpy.action.server import ServerGoalHandle
from unique_identifier_msgs.msg import UUID

Handle = ServerGoalHandle
NONE, UNKNOWN_GOAL_ID, GOAL_TERMINATED = 0, 2, 3


@pytest.fixture
def patient() -> Patient:
    return Patient()


@pytest.fixture
def arena(make_node: MakeNode, spin: Spin, patient: Patient) -> Arena:
    return Arena(make_node, spin, patient, threads=6, cancel=accept_cancel)


def test_cancelling_by_id(arena: Arena, patient: Patient) -> None:
    handle, other = arena.accept(1), arena.accept(2)
    patient.gate.reached.expect(2)
    answer = result_of(handle.cancel_goal_async())
    assert answer.return_code == NONE
    assert [bytes(goal.goal_id.uuid) for goal in answer.goals_canceling] == [id_of(handle)]
    assert answer.goals_canceling[0].stamp != Time()
    assert arena.seen(handle, 'CANCELING') == ['EXECUTING', 'CANCELING']
    patient.gate.open()
    assert arena.result(handle) == ('CANCELED', [1])
    assert arena.result(other) == ('SUCCEEDED', [2])
    assert arena.seen(handle, 'CANCELED') == ['EXECUTING', 'CANCELING', 'CANCELED']


def test_cancelling_an_unknown_goal(arena: Arena) -> None:
    assert arena.cancel(UUID(uuid=[9] * 16)) == (UNKNOWN_GOAL_ID, [])


def test_cancelling_a_goal_that_has_ended(arena: Arena, patient: Patient) -> None:
    patient.gate.open()
    handle = arena.accept()
    arena.result(handle)
    assert arena.cancel(handle.goal_id) == (GOAL_TERMINATED, [])


def test_cancelling_a_goal_twice(arena: Arena, patient: Patient) -> None:
    handle = arena.accept()
    assert arena.cancel(handle.goal_id)[0] == NONE
    assert arena.cancel(handle.goal_id) == (GOAL_TERMINATED, [])
    patient.gate.open()
    assert arena.result(handle)[0] == 'CANCELED'


def test_cancelling_everything(arena: Arena, patient: Patient) -> None:
    handles = [arena.accept(order) for order in range(3)]
    assert arena.cancel() == (NONE, [id_of(handle) for handle in handles])
    patient.gate.open()
    assert [arena.result(handle)[0] for handle in handles] == ['CANCELED'] * 3
    assert arena.cancel() == (NONE, [])


def stamps_of(arena: Arena, *handles: ClientGoalHandle) -> list[Time]:
    for handle in handles:
        arena.seen(handle, 'EXECUTING')
    by_id = {
        bytes(entry.goal_info.goal_id.uuid): entry.goal_info.stamp
        for entry in arena.statuses.items[-1].status_list
    }
    return [by_id[id_of(handle)] for handle in handles]


def test_cancelling_what_was_accepted_up_to_a_time(arena: Arena, patient: Patient) -> None:
    first, second, third = (arena.accept(order) for order in range(3))
    patient.gate.reached.expect(3)
    stamp = stamps_of(arena, first, second, third)[1]
    assert arena.cancel(NO_ID, stamp) == (NONE, [id_of(first), id_of(second)])
    patient.gate.open()
    assert [arena.result(handle)[0] for handle in (first, second, third)] == [
        'CANCELED', 'CANCELED', 'SUCCEEDED'
    ]  # fmt: skip


def test_cancelling_a_goal_and_all_older_ones(arena: Arena, patient: Patient) -> None:
    first, second, third = (arena.accept(order) for order in range(3))
    patient.gate.reached.expect(3)
    stamp = stamps_of(arena, first, second, third)[0]
    assert arena.cancel(third.goal_id, stamp) == (NONE, [id_of(first), id_of(third)])
    patient.gate.open()
    assert arena.result(second)[0] == 'SUCCEEDED'


@pytest.mark.parametrize('answer', [CancelResponse.REJECT, None, True], ids=repr)
def test_a_cancellation_that_is_refused(make_node: MakeNode, spin: Spin, answer: object) -> None:
    patient = Patient()
    arena = Arena(make_node, spin, patient, cancel=lambda _: answer)
    handle = arena.accept(4)
    assert arena.cancel(handle.goal_id) == (NONE, [])
    patient.gate.open()
    assert arena.result(handle) == ('SUCCEEDED', [4])
    assert arena.seen(handle, 'SUCCEEDED') == ['EXECUTING', 'SUCCEEDED']


def test_by_default_nothing_is_cancelled(make_node: MakeNode, spin: Spin) -> None:
    patient = Patient()
    arena = Arena(make_node, spin, patient)
    handle = arena.accept(4)
    assert arena.cancel(handle.goal_id) == (NONE, [])
    patient.gate.open()
    assert arena.result(handle) == ('SUCCEEDED', [4])


def test_each_goal_is_asked_once_and_the_refused_ones_go_on(make_node: MakeNode, spin: Spin) -> None:
    """rclpy skips every second goal here, and reports it as cancelling."""
    patient, asked = Patient(), Collector[int]()

    def cancel(handle: Handle) -> CancelResponse:
        asked(handle.request.order)
        return CancelResponse.ACCEPT if handle.request.order % 2 else CancelResponse.REJECT

    arena = Arena(make_node, spin, patient, threads=6, cancel=cancel)
    handles = [arena.accept(order) for order in range(4)]
    assert arena.cancel() == (NONE, [id_of(handles[1]), id_of(handles[3])])
    assert asked.items == [0, 1, 2, 3]
    patient.gate.open()
    ends = [arena.result(handle)[0] for handle in handles]
    assert ends == ['SUCCEEDED', 'CANCELED', 'SUCCEEDED', 'CANCELED']


@pytest.mark.parametrize('threads', [1, 4], ids=['single', 'multi'])
def test_a_cancel_callback_that_raises_refuses_and_comes_out_of_spin(
    make_node: MakeNode, spin: Spin, threads: int
) -> None:
    kept: Collector[Handle] = Collector()

    def cancel(handle: Handle) -> CancelResponse:
        raise ZeroDivisionError

    arena = Arena(make_node, spin, succeed, cancel=cancel, accepted=kept, threads=threads)
    handle = arena.accept(3)
    assert arena.cancel(handle.goal_id) == (NONE, [])
    arena.spinner.expect_raised(ZeroDivisionError)
    kept.expect()[0].execute()
    assert arena.result(handle) == ('SUCCEEDED', [3])


@pytest.mark.parametrize(
    ('end', 'status'),
    [(Handle.succeed, 'SUCCEEDED'), (Handle.abort, 'ABORTED'), (lambda _: None, 'ABORTED')],
    ids=['succeed', 'abort', 'nothing'],
)
def test_a_server_may_end_a_cancelled_goal_otherwise(
    make_node: MakeNode, spin: Spin, end: Any, status: str
) -> None:
    gate = Gate()

    def execute(handle: Handle) -> Fibonacci.Result:
        gate(handle)
        end(handle)
        return Result(sequence=[4])

    arena = Arena(make_node, spin, execute, cancel=accept_cancel)
    handle = arena.accept()
    gate.reached.expect()  # before that the two transitions might share one array
    assert arena.cancel(handle.goal_id)[0] == NONE
    gate.open()
    assert arena.result(handle) == (status, [4])
    assert arena.seen(handle, status) == ['EXECUTING', 'CANCELING', status]


def test_a_cancellation_racing_completion_ends_in_one_state_on_both_sides(
    make_node: MakeNode, spin: Spin
) -> None:
    start, ended = threading.Barrier(2, timeout=PATIENCE), Collector[str]()

    def execute(handle: Handle) -> Fibonacci.Result:
        start.wait(PATIENCE)
        if handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.succeed()
        ended(NAMES[handle.status])
        return Result()

    arena = Arena(make_node, spin, execute, threads=6, cancel=accept_cancel)
    for number in range(30):
        handle = arena.accept()
        start.wait(PATIENCE)
        answer = result_of(handle.cancel_goal_async())
        status = arena.result(handle)[0]
        assert ended.expect(number + 1)[-1] == status
        assert arena.seen(handle, status)[-1] == status
        cancelling = [bytes(goal.goal_id.uuid) for goal in answer.goals_canceling]
        assert (answer.return_code, cancelling) in [(NONE, [id_of(handle)]), (GOAL_TERMINATED, [])]
        if status == 'CANCELED':
            assert answer.return_code == NONE
