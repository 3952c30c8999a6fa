from __future__ import annotations

import os
import tracemalloc

import pytest

from goalwire.errors import InvalidTransition
from goalwire.rules.goals import (
    NO_ID,
    CancelCode,
    GoalEvent,
    GoalServer,
    GoalStatus,
    decode_status_array,
    new_goal_id,
)
from goalwire.rules.goals.effects import (
    Accepted,
    AskCancel,
    AskGoal,
    AssumedAborted,
    Execute,
    PublishStatus,
    ReplyCancel,
    ReplyGoal,
    ReplyResult,
    ServerEffect,
    WakeAt,
)

A, B, C = (bytes([n]) * 16 for n in range(1, 4))
S = 1_000_000_000

Server = GoalServer[str, str]


def accepted(server: Server, *goal_ids: bytes) -> None:
    """Have goals accepted, each one second after the other (ROS time)."""
    for stamp, goal_id in enumerate(goal_ids, 1):
        server.on_goal_request(goal_id, 'send', now=0)
        server.on_goal_decision(goal_id, accepted=True, stamp_ns=stamp * S)


def executing(*goal_ids: bytes, result_timeout_ns: int = 10 * S) -> Server:
    server = Server(result_timeout_ns)
    accepted(server, *goal_ids)
    for goal_id in goal_ids:
        server.on_execute(goal_id, now=0)
    server.take_status()
    return server


def finish(
    server: Server, goal_id: bytes, event: GoalEvent, result: str, now: int
) -> list[ServerEffect[str, str]]:
    """End a goal whose execute callback returns at once."""
    return [*server.on_event(goal_id, event, now), *server.on_result(goal_id, result, now)]


def published(server: Server) -> list[tuple[bytes, GoalStatus]] | None:
    payload = server.take_status()
    return None if payload is None else decode_status_array(payload)


# ---- goals ----


def test_a_goal_is_asked_about_then_answered_then_handed_over() -> None:
    server = Server()
    assert server.on_goal_request(A, 'send', now=0) == [AskGoal(A)]
    assert server.on_goal_decision(A, accepted=True, stamp_ns=7) == [ReplyGoal('send', True, 7), Accepted(A)]
    assert server.status(A) is GoalStatus.ACCEPTED


def test_a_goal_that_is_executed_at_once_is_never_seen_as_accepted() -> None:
    server = Server()
    accepted(server, A)
    assert server.on_execute(A, now=0) == [PublishStatus(), Execute(A)]
    assert published(server) == [(A, GoalStatus.EXECUTING)]


def test_a_rejected_goal_is_answered_with_stamp_zero_and_leaves_nothing() -> None:
    server = Server()
    server.on_goal_request(A, 'send', now=0)
    assert server.on_goal_decision(A, accepted=False, stamp_ns=7) == [ReplyGoal('send', False, 0)]
    assert published(server) is None
    assert server.on_result_request(A, 'get', now=0) == [ReplyResult('get', GoalStatus.UNKNOWN, None)]
    assert server.on_goal_request(A, 'again', now=0) == [AskGoal(A)]


def test_a_duplicate_id_is_refused_while_the_first_is_being_decided() -> None:
    server = Server()
    server.on_goal_request(A, 'first', now=0)
    assert server.on_goal_request(A, 'second', now=0) == [ReplyGoal('second', False, 0)]
    assert server.on_goal_decision(A, accepted=True, stamp_ns=1)[0] == ReplyGoal('first', True, 1)


def test_a_duplicate_id_is_refused_as_long_as_the_goal_is_retained() -> None:
    server = executing(A)
    refused = [ReplyGoal('again', False, 0)]
    assert server.on_goal_request(A, 'again', now=0) == refused
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    assert server.on_goal_request(A, 'again', now=10 * S - 1) == refused
    assert server.on_goal_request(A, 'again', now=10 * S) == [AskGoal(A)]


def test_a_decision_about_nothing_does_nothing() -> None:
    server = executing(A)
    assert server.on_goal_decision(A, accepted=False, stamp_ns=1) == []
    assert server.on_goal_decision(B, accepted=True, stamp_ns=1) == []


def test_a_deferred_goal_waits_for_execute() -> None:
    server = Server()
    accepted(server, A)
    assert server.on_result_request(A, 'get', now=0) == []
    assert server.on_execute(A, now=0) == [PublishStatus(), Execute(A)]


@pytest.mark.parametrize(
    ('event', 'status'),
    [(GoalEvent.SUCCEED, GoalStatus.SUCCEEDED), (GoalEvent.ABORT, GoalStatus.ABORTED)],
)
def test_the_end_is_published_before_the_result_is_sent(event: GoalEvent, status: GoalStatus) -> None:
    server = executing(A)
    server.on_result_request(A, 'get', now=0)
    assert server.on_event(A, event, now=5) == [PublishStatus()]
    assert published(server) == [(A, status)]
    assert server.on_result(A, 'done', now=6) == [ReplyResult('get', status, 'done'), WakeAt(6 + 10 * S)]


def test_execution_that_sets_no_terminal_state_aborts_and_says_so() -> None:
    server = executing(A)
    server.on_result_request(A, 'get', now=0)
    assert server.on_result(A, None, now=5) == [
        AssumedAborted(A),
        PublishStatus(),
        ReplyResult('get', GoalStatus.ABORTED, None),
        WakeAt(5 + 10 * S),
    ]


def test_a_result_asked_for_between_end_and_return_waits_for_the_return() -> None:
    server = executing(A)
    server.on_event(A, GoalEvent.SUCCEED, now=5)
    assert server.on_result_request(A, 'get', now=6) == []
    assert server.on_result(A, 'done', now=7)[0] == ReplyResult('get', GoalStatus.SUCCEEDED, 'done')


def test_a_second_result_for_one_goal_is_ignored() -> None:
    server = executing(A)
    finish(server, A, GoalEvent.SUCCEED, 'first', now=5)
    assert server.on_result(A, 'second', now=6) == []
    assert server.on_result_request(A, 'get', now=7) == [ReplyResult('get', GoalStatus.SUCCEEDED, 'first')]


def test_a_goal_that_ends_without_ever_being_executed_answers_with_the_default() -> None:
    server = Server()
    accepted(server, A)
    server.on_result_request(A, 'get', now=0)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    assert server.on_event(A, GoalEvent.CANCELED, now=5) == [
        PublishStatus(),
        ReplyResult('get', GoalStatus.CANCELED, None),
        WakeAt(5 + 10 * S),
    ]


@pytest.mark.parametrize('event', [GoalEvent.SUCCEED, GoalEvent.ABORT, GoalEvent.CANCELED])
def test_a_deferred_goal_cannot_end_by_itself(event: GoalEvent) -> None:
    server = Server()
    accepted(server, A)
    with pytest.raises(InvalidTransition):
        server.on_event(A, event, now=0)
    assert server.status(A) is GoalStatus.ACCEPTED


def test_nothing_leaves_a_terminal_state() -> None:
    server = executing(A)
    server.on_event(A, GoalEvent.SUCCEED, now=0)
    for event in (GoalEvent.SUCCEED, GoalEvent.ABORT, GoalEvent.CANCELED):
        with pytest.raises(InvalidTransition, match=f'from state SUCCEEDED with event {event.name}'):
            server.on_event(A, event, now=0)
    with pytest.raises(InvalidTransition, match='from state SUCCEEDED with event EXECUTE'):
        server.on_execute(A, now=0)
    assert server.status(A) is GoalStatus.SUCCEEDED


def test_a_goal_is_executed_once() -> None:
    server = executing(A)
    with pytest.raises(InvalidTransition, match='from state EXECUTING with event EXECUTE'):
        server.on_execute(A, now=0)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    with pytest.raises(InvalidTransition, match='from state CANCELING with event EXECUTE'):
        server.on_execute(A, now=0)


def test_a_goal_handle_may_outlive_its_goal() -> None:
    server = executing(A, result_timeout_ns=0)
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    assert server.on_execute(A, now=0) == []
    assert server.on_event(A, GoalEvent.ABORT, now=0) == []
    assert finish(server, A, GoalEvent.ABORT, 'late', now=0) == []
    assert server.status(A) is GoalStatus.UNKNOWN


def test_what_the_driver_keeps_of_a_goal_leaves_its_record_with_the_end() -> None:
    server, handle = Server(), object()
    server.on_goal_request(A, 'send', now=0)
    goal = server.deciding[A]
    server.on_goal_decision(A, accepted=True, stamp_ns=1, handle=handle)
    assert server.goals == {A: goal}
    assert goal.handle is handle
    server.on_execute(A, now=0)
    server.on_event(A, GoalEvent.SUCCEED, now=0)
    assert goal.handle is handle  # it runs yet
    server.on_result(A, 'done', now=0)
    assert (goal.status, goal.result, goal.handle) == (GoalStatus.SUCCEEDED, 'done', None)
    server.on_time(10 * S)
    assert server.goals == {}
    assert goal.status is GoalStatus.UNKNOWN


# ---- status arrays ----


def test_the_array_holds_every_retained_goal_in_order_of_acceptance() -> None:
    server = executing(A, B, C)
    finish(server, B, GoalEvent.SUCCEED, 'done', now=0)
    assert published(server) == [
        (A, GoalStatus.EXECUTING),
        (B, GoalStatus.SUCCEEDED),
        (C, GoalStatus.EXECUTING),
    ]


def test_transitions_of_one_burst_share_an_array() -> None:
    server = executing(A, B)
    finish(server, A, GoalEvent.SUCCEED, 'a', now=0)
    finish(server, B, GoalEvent.ABORT, 'b', now=0)
    assert published(server) == [(A, GoalStatus.SUCCEEDED), (B, GoalStatus.ABORTED)]
    assert published(server) is None


def test_expiry_is_not_published_by_itself() -> None:
    server = executing(A, B)
    finish(server, A, GoalEvent.SUCCEED, 'a', now=0)
    published(server)
    server.on_time(10 * S)
    assert published(server) is None
    server.on_event(B, GoalEvent.SUCCEED, now=10 * S)
    assert published(server) == [(B, GoalStatus.SUCCEEDED)]


def test_the_end_of_a_goal_that_is_forgotten_at_once_is_still_published() -> None:
    server = executing(A, result_timeout_ns=0)
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    assert published(server) == [(A, GoalStatus.SUCCEEDED)]


# ---- cancelling ----


def test_cancelling_publishes_before_it_answers() -> None:
    server = executing(A)
    assert server.on_cancel_request(A, 0, 'cancel', now=0) == [AskCancel(0, A)]
    assert server.on_cancel_decision(0, A, accepted=True, now=0) == [
        PublishStatus(),
        ReplyCancel('cancel', CancelCode.NONE, ((A, 1 * S),)),
    ]
    assert published(server) == [(A, GoalStatus.CANCELING)]
    server.on_event(A, GoalEvent.CANCELED, now=1)
    assert published(server) == [(A, GoalStatus.CANCELED)]


def test_a_refused_cancellation_is_answered_as_rclpy_does() -> None:
    server = executing(A)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    assert server.on_cancel_decision(0, A, accepted=False, now=0) == [
        ReplyCancel('cancel', CancelCode.NONE, ())
    ]
    assert server.status(A) is GoalStatus.EXECUTING
    assert published(server) is None


def test_unknown_ended_and_expired_goals_are_told_apart() -> None:
    server = executing(A)
    assert server.on_cancel_request(B, 0, 'c', now=0) == [ReplyCancel('c', CancelCode.UNKNOWN_GOAL_ID, ())]
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    assert server.on_cancel_request(A, 0, 'c', now=1) == [ReplyCancel('c', CancelCode.GOAL_TERMINATED, ())]
    late = server.on_cancel_request(A, 0, 'c', now=10 * S)
    assert late == [ReplyCancel('c', CancelCode.UNKNOWN_GOAL_ID, ())]


def test_a_goal_that_is_being_decided_is_not_known_yet() -> None:
    server = Server()
    server.on_goal_request(A, 'send', now=0)
    assert server.on_cancel_request(A, 0, 'c', now=0) == [ReplyCancel('c', CancelCode.UNKNOWN_GOAL_ID, ())]
    assert server.on_cancel_request(NO_ID, 0, 'c', now=0) == [ReplyCancel('c', CancelCode.NONE, ())]


def test_cancelling_twice_is_refused_by_id() -> None:
    server = executing(A)
    server.on_cancel_request(A, 0, 'first', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    second = server.on_cancel_request(A, 0, 'second', now=0)
    assert second == [ReplyCancel('second', CancelCode.GOAL_TERMINATED, ())]


def test_of_two_requests_that_are_accepted_together_one_cancels() -> None:
    server = executing(A)
    server.on_cancel_request(A, 0, 'first', now=0)
    server.on_cancel_request(A, 0, 'second', now=0)
    assert server.on_cancel_decision(1, A, accepted=True, now=0)[-1] == ReplyCancel(
        'second', CancelCode.NONE, ((A, 1 * S),)
    )
    assert server.on_cancel_decision(0, A, accepted=True, now=0) == [
        ReplyCancel('first', CancelCode.GOAL_TERMINATED, ())
    ]


def test_everything_is_asked_once_each_in_order_of_acceptance() -> None:
    server = executing(A, B, C)
    assert server.on_cancel_request(NO_ID, 0, 'all', now=0) == [
        AskCancel(0, A),
        AskCancel(0, B),
        AskCancel(0, C),
    ]


def test_only_goals_that_went_to_canceling_are_listed() -> None:
    server = executing(A, B, C)
    server.on_cancel_request(NO_ID, 0, 'all', now=0)
    assert server.on_cancel_decision(0, C, accepted=True, now=0) == []
    assert server.on_cancel_decision(0, A, accepted=True, now=0) == []
    assert server.on_cancel_decision(0, B, accepted=False, now=0) == [
        PublishStatus(),
        ReplyCancel('all', CancelCode.NONE, ((A, 1 * S), (C, 3 * S))),
    ]
    statuses = [server.status(goal_id) for goal_id in (A, B, C)]
    assert statuses == [GoalStatus.CANCELING, GoalStatus.EXECUTING, GoalStatus.CANCELING]


def test_refusing_everything_cancels_nothing() -> None:
    # rclpy's server skips every second goal here and lists it as cancelling.
    server = executing(A, B, C)
    server.on_cancel_request(NO_ID, 0, 'all', now=0)
    for goal_id in (A, B):
        server.on_cancel_decision(0, goal_id, accepted=False, now=0)
    assert server.on_cancel_decision(0, C, accepted=False, now=0) == [ReplyCancel('all', CancelCode.NONE, ())]


def test_a_stamp_cancels_what_was_accepted_by_then() -> None:
    server = executing(A, B, C)
    assert server.on_cancel_request(NO_ID, 2 * S, 'old', now=0) == [AskCancel(0, A), AskCancel(0, B)]
    assert server.on_cancel_request(C, 1 * S, 'both', now=0) == [AskCancel(1, A), AskCancel(1, C)]


def test_completion_wins_over_a_cancellation_that_is_decided_later() -> None:
    server = executing(A)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    assert server.on_cancel_decision(0, A, accepted=True, now=0) == [
        ReplyCancel('cancel', CancelCode.GOAL_TERMINATED, ())
    ]
    assert server.status(A) is GoalStatus.SUCCEEDED


def test_completion_and_expiry_win_as_well() -> None:
    server = executing(A, result_timeout_ns=0)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    assert server.on_cancel_decision(0, A, accepted=True, now=0) == [
        ReplyCancel('cancel', CancelCode.GOAL_TERMINATED, ())
    ]


def test_a_goal_that_ends_while_all_are_cancelled_is_left_out() -> None:
    server = executing(A, B)
    server.on_cancel_request(NO_ID, 0, 'all', now=0)
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    assert server.on_cancel_decision(0, B, accepted=True, now=0)[-1] == ReplyCancel(
        'all', CancelCode.NONE, ((B, 2 * S),)
    )


def test_a_goal_that_is_canceling_may_still_succeed_or_abort() -> None:
    server = executing(A, B)
    server.on_cancel_request(NO_ID, 0, 'all', now=0)
    for goal_id in (A, B):
        server.on_cancel_decision(0, goal_id, accepted=True, now=0)
    server.on_event(A, GoalEvent.SUCCEED, now=0)
    server.on_event(B, GoalEvent.ABORT, now=0)
    assert (server.status(A), server.status(B)) == (GoalStatus.SUCCEEDED, GoalStatus.ABORTED)


def test_a_goal_cancelled_before_it_is_executed_is_executed_as_canceling() -> None:
    server = Server()
    accepted(server, A)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    assert server.on_execute(A, now=0) == [Execute(A)]
    assert server.status(A) is GoalStatus.CANCELING


def test_a_decision_nobody_waits_for_does_nothing() -> None:
    server = executing(A)
    server.on_cancel_request(A, 0, 'cancel', now=0)
    server.on_cancel_decision(0, A, accepted=False, now=0)
    assert server.on_cancel_decision(0, A, accepted=True, now=0) == []
    assert server.on_cancel_decision(9, A, accepted=True, now=0) == []
    assert server.status(A) is GoalStatus.EXECUTING


# ---- results ----


def test_a_result_can_be_asked_for_again_until_it_expires() -> None:
    server = executing(A)
    finish(server, A, GoalEvent.SUCCEED, 'done', now=0)
    kept = [ReplyResult('get', GoalStatus.SUCCEEDED, 'done')]
    assert server.on_result_request(A, 'get', now=1) == kept
    assert server.on_result_request(A, 'get', now=9_900_000_000) == kept
    gone = server.on_result_request(A, 'get', now=10_100_000_000)
    assert gone == [ReplyResult('get', GoalStatus.UNKNOWN, None)]


def test_results_expire_by_their_own_times_when_time_goes_back() -> None:
    server = executing(A, B)
    assert WakeAt(110 * S) in finish(server, A, GoalEvent.SUCCEED, 'a', now=100 * S)
    assert WakeAt(15 * S) in finish(server, B, GoalEvent.SUCCEED, 'b', now=5 * S)
    assert server.on_time(15 * S) == [WakeAt(110 * S)]
    assert server.status(B) is GoalStatus.UNKNOWN
    assert server.status(A) is GoalStatus.SUCCEEDED
    assert server.on_time(110 * S) == []
    assert server.status(A) is GoalStatus.UNKNOWN


def test_an_unknown_goal_is_answered_at_once() -> None:
    assert Server().on_result_request(A, 'get', now=0) == [ReplyResult('get', GoalStatus.UNKNOWN, None)]


def test_with_timeout_zero_only_clients_that_wait_get_the_result() -> None:
    server = executing(A, result_timeout_ns=0)
    server.on_result_request(A, 'waiting', now=0)
    assert finish(server, A, GoalEvent.SUCCEED, 'done', now=0) == [
        PublishStatus(),
        ReplyResult('waiting', GoalStatus.SUCCEEDED, 'done'),
    ]
    late = server.on_result_request(A, 'late', now=0)
    assert late == [ReplyResult('late', GoalStatus.UNKNOWN, None)]


def test_with_a_negative_timeout_results_are_kept_for_ever() -> None:
    server = executing(A, result_timeout_ns=-1)
    assert finish(server, A, GoalEvent.SUCCEED, 'done', now=0) == [PublishStatus()]
    server.on_time(10**30)
    kept = server.on_result_request(A, 'get', now=10**30)
    assert kept == [ReplyResult('get', GoalStatus.SUCCEEDED, 'done')]


def test_one_wake_up_at_a_time_is_asked_for_and_each_names_the_next() -> None:
    server = executing(A, B, C)
    assert finish(server, A, GoalEvent.SUCCEED, '', now=1)[-1] == WakeAt(10 * S + 1)
    assert finish(server, B, GoalEvent.SUCCEED, '', now=2) == [PublishStatus()]
    assert server.on_time(10 * S + 1) == [WakeAt(10 * S + 2)]
    assert server.on_time(10 * S + 2) == []
    assert finish(server, C, GoalEvent.SUCCEED, '', now=11 * S)[-1] == WakeAt(21 * S)


# ---- the end ----


def test_closing_answers_everything_that_is_open() -> None:
    server = executing(A, B)
    server.on_goal_request(C, 'send', now=0)
    server.on_result_request(A, 'get a', now=0)
    server.on_cancel_request(NO_ID, 0, 'all', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    server.on_event(B, GoalEvent.SUCCEED, now=0)
    server.on_result_request(B, 'get b', now=0)
    assert server.on_close() == [
        ReplyGoal('send', False, 0),
        PublishStatus(),
        ReplyCancel('all', CancelCode.NONE, ((A, 1 * S),)),
        PublishStatus(),
        ReplyResult('get a', GoalStatus.ABORTED, None),
        ReplyResult('get b', GoalStatus.SUCCEEDED, None),
    ]
    assert published(server) == [(A, GoalStatus.ABORTED), (B, GoalStatus.SUCCEEDED)]


def test_closing_aborts_a_deferred_goal() -> None:
    server = Server()
    accepted(server, A)
    server.on_result_request(A, 'get', now=0)
    assert server.on_close() == [PublishStatus(), ReplyResult('get', GoalStatus.ABORTED, None)]


def test_after_closing_goals_are_refused_and_callbacks_that_end_late_do_nothing() -> None:
    server = executing(A)
    server.on_close()
    assert server.on_goal_request(B, 'send', now=0) == [ReplyGoal('send', False, 0)]
    assert finish(server, A, GoalEvent.SUCCEED, 'late', now=0) == []
    assert server.on_close() == [PublishStatus()]


# ---- size ----


def run_goals(server: Server, count: int, start: int) -> int:
    now = start
    for _ in range(count):
        goal_id = new_goal_id()
        accepted(server, goal_id)
        server.on_execute(goal_id, now=0)
        server.on_result_request(goal_id, 'get', now)
        finish(server, goal_id, GoalEvent.SUCCEED, 'done', now)
        server.take_status()
        now += 1 * S
    server.on_time(now + 10 * S)
    return now + 10 * S


@pytest.mark.slow
def test_memory_is_flat_after_many_goals() -> None:
    """A byte kept of each would be seen. GOALWIRE_TEST_GOALS=100000 makes them more."""
    number = int(os.environ.get('GOALWIRE_TEST_GOALS', '20000'))
    server = Server()
    now = run_goals(server, 1000, start=0)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        run_goals(server, number, start=now)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert grown < 20_000
    statistics = server.statistics()
    assert (statistics.retained, statistics.deciding, statistics.waiting_for_results) == (0, 0, 0)


def test_a_thousand_goals_at_once_each_get_their_own_result() -> None:
    ids = [new_goal_id() for _ in range(1000)]
    server = executing(*ids)
    for goal_id in ids:
        server.on_result_request(goal_id, f'get {goal_id.hex()}', now=0)
    assert server.statistics().active == 1000
    for goal_id in reversed(ids):
        replies = finish(server, goal_id, GoalEvent.SUCCEED, goal_id.hex(), now=0)
        assert replies[1] == ReplyResult(f'get {goal_id.hex()}', GoalStatus.SUCCEEDED, goal_id.hex())
    assert published(server) == [(goal_id, GoalStatus.SUCCEEDED) for goal_id in ids]
