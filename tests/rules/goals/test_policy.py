"""How many goals run at a time, what becomes of the others, and of those whose client has gone."""

from __future__ import annotations

from typing import Any

import pytest

from goalwire.errors import InvalidTransition
from goalwire.rules.goals import (
    NO_ID,
    CancelCode,
    GoalEvent,
    GoalPolicy,
    GoalServer,
    GoalStatus,
    decode_status_array,
    parallel,
    preempt,
    queue,
    single,
)
from goalwire.rules.goals.effects import (
    AskCancel,
    AskGoal,
    Execute,
    PublishStatus,
    ReplyCancel,
    ReplyGoal,
    ReplyResult,
    StoppedByServer,
    WakeAt,
)

A, B, C, D = (bytes([n]) * 16 for n in range(1, 5))
S = 1_000_000_000
ME, YOU = b'me', b'you'
QUEUE = queue(9)
REFUSED = [ReplyGoal('send', False, 0)]
PUBLISHED = PublishStatus()

Server = GoalServer[str, str]


def send(server: Server, goal_id: bytes, client: bytes = ME) -> list[Any]:
    """Send a goal that the user accepts, and execute it; return what the server does about it."""
    effects: list[Any] = server.on_goal_request(goal_id, 'send', now=0, client=client)
    if effects != [AskGoal(goal_id)]:
        return effects
    effects = server.on_goal_decision(goal_id, accepted=True, stamp_ns=S)
    return effects if effects == REFUSED else list(server.on_execute(goal_id, now=0))


def serving(policy: GoalPolicy, *goal_ids: bytes) -> Server:
    server = Server(policy=policy)
    for goal_id in goal_ids:
        send(server, goal_id)
    server.take_status()
    return server


def published(server: Server) -> dict[bytes, GoalStatus]:
    payload = server.take_status()
    return {} if payload is None else dict(decode_status_array(payload))


def finish(server: Server, goal_id: bytes, event: GoalEvent = GoalEvent.SUCCEED) -> list[Any]:
    return [*server.on_event(goal_id, event, now=0), *server.on_result(goal_id, 'done', now=0)]


# ---- taking turns ----


def test_an_execution_comes_back_when_its_goals_turn_has_come() -> None:
    server = serving(QUEUE, A)
    for goal_id in (B, C):
        server.on_goal_request(goal_id, 'send', now=0)
        server.on_goal_decision(goal_id, accepted=True, stamp_ns=S)
    assert server.on_execute(C, 0, 'of C') == [PUBLISHED]
    assert server.on_execute(B, 0, 'of B') == [PUBLISHED]
    assert server.on_execute(C, 0, 'again') == []
    assert finish(server, A)[-1] == Execute(C, 'of C')
    assert finish(server, C)[-1] == Execute(B, 'of B')
    assert server.goals[B].execution is None


def test_a_goal_that_ends_before_its_turn_leaves_no_execution() -> None:
    server = serving(QUEUE, A)
    server.on_goal_request(B, 'send', now=0)
    server.on_goal_decision(B, accepted=True, stamp_ns=S, handle='handle')
    server.on_execute(B, 0, 'of B')
    server.on_cancel_request(B, 0, 'cancel', now=0)
    server.on_cancel_decision(0, B, accepted=True, now=0)
    goal = server.goals[B]
    assert (goal.status, goal.handle, goal.execution) == (GoalStatus.CANCELED, None, None)


# ---- refusing ----


@pytest.mark.parametrize(('policy', 'places'), [(single(), 1), (parallel(2), 2), (queue(1), 2)])
def test_what_finds_every_place_taken_is_refused_before_the_user_is_asked(
    policy: GoalPolicy, places: int
) -> None:
    server = serving(policy, *(A, B)[:places])
    assert server.on_goal_request(D, 'send', now=0) == REFUSED
    statistics = server.statistics()
    assert (statistics.accepted, statistics.refused, statistics.active) == (places, 1, places)
    finish(server, A)
    assert server.on_goal_request(D, 'send', now=0) == [AskGoal(D)]


def test_the_last_place_goes_to_the_goal_that_is_decided_first() -> None:
    server = Server(policy=single())
    for goal_id in (A, B):
        assert server.on_goal_request(goal_id, 'send', now=0) == [AskGoal(goal_id)]
    assert server.on_goal_decision(B, accepted=True, stamp_ns=S)[0] == ReplyGoal('send', True, S)
    assert server.on_goal_decision(A, accepted=True, stamp_ns=S) == REFUSED
    assert server.status(A) is GoalStatus.UNKNOWN


def test_a_goal_that_the_user_refuses_takes_no_place() -> None:
    server = Server(policy=single())
    server.on_goal_request(A, 'send', now=0)
    server.on_goal_decision(A, accepted=False, stamp_ns=S)
    assert Execute(B) in send(server, B)


def test_a_place_is_taken_until_the_execution_is_over() -> None:
    server = serving(single(), A)
    server.on_event(A, GoalEvent.SUCCEED, now=0)
    assert send(server, B) == REFUSED
    server.on_result(A, 'done', now=0)
    assert Execute(B) in send(server, B)


@pytest.mark.parametrize('wrong', [lambda: parallel(0), lambda: queue(-1), lambda: GoalPolicy(-1)])
def test_a_number_that_makes_no_sense_is_refused(wrong: Any) -> None:
    with pytest.raises(ValueError, match='goal'):
        wrong()


# ---- waiting for a turn ----


def test_goals_in_a_queue_are_accepted_and_run_in_turn() -> None:
    server = serving(queue(2), A)
    assert send(server, B) == [PUBLISHED]
    assert send(server, C) == [PUBLISHED]
    assert published(server) == {A: GoalStatus.EXECUTING, B: GoalStatus.ACCEPTED, C: GoalStatus.ACCEPTED}
    assert finish(server, A) == [PUBLISHED, WakeAt(10 * S), PUBLISHED, Execute(B)]
    assert published(server) == {A: GoalStatus.SUCCEEDED, B: GoalStatus.EXECUTING, C: GoalStatus.ACCEPTED}
    server.on_event(B, GoalEvent.ABORT, now=0)
    assert server.on_result(B, 'late', now=0) == [PUBLISHED, Execute(C)]


def test_a_goal_that_waits_is_not_executed_twice() -> None:
    server = serving(queue(2), A, B)
    assert server.on_execute(B, now=0) == []
    assert finish(server, A)[-1] == Execute(B)
    with pytest.raises(InvalidTransition):
        server.on_execute(B, now=0)


def test_cancelling_a_goal_that_waits_ends_it_at_once_and_the_next_moves_up() -> None:
    server = serving(queue(2), A, B, C)
    server.on_result_request(B, 'get', now=0)
    assert server.on_cancel_request(B, 0, 'cancel', now=0) == [AskCancel(0, B)]
    assert server.on_cancel_decision(0, B, accepted=True, now=0) == [
        PUBLISHED,
        ReplyResult('get', GoalStatus.CANCELED, None),
        WakeAt(10 * S),
        PUBLISHED,
        ReplyCancel('cancel', CancelCode.NONE, ((B, S),)),
    ]
    assert published(server)[B] is GoalStatus.CANCELED
    assert server.on_result_request(B, 'again', now=0) == [ReplyResult('again', GoalStatus.CANCELED, None)]
    assert finish(server, A)[-1] == Execute(C)


def test_cancelling_all_leaves_nobody_to_run() -> None:
    server = serving(queue(2), A, B, C)
    asked = server.on_cancel_request(NO_ID, 0, 'cancel', now=0)
    assert asked == [AskCancel(0, A), AskCancel(0, B), AskCancel(0, C)]
    for goal_id in (A, B):
        server.on_cancel_decision(0, goal_id, accepted=True, now=0)
    reply = server.on_cancel_decision(0, C, accepted=True, now=0)[-1]
    assert reply == ReplyCancel('cancel', CancelCode.NONE, ((A, S), (B, S), (C, S)))
    assert not any(isinstance(effect, Execute) for effect in finish(server, A, GoalEvent.CANCELED))
    assert server.statistics().canceled == 3


def test_a_deferred_goal_that_was_cancelled_ends_where_it_would_have_to_wait() -> None:
    server = serving(queue(2), A)
    server.on_goal_request(B, 'send', now=0)
    server.on_goal_decision(B, accepted=True, stamp_ns=S)
    server.on_cancel_request(B, 0, 'cancel', now=0)
    server.on_cancel_decision(0, B, accepted=True, now=0)
    assert server.on_execute(B, now=0) == [PUBLISHED, WakeAt(10 * S)]
    assert server.status(B) is GoalStatus.CANCELED


def test_closing_runs_nobody_who_waits() -> None:
    server = serving(queue(2), A, B)
    server.on_result_request(B, 'get', now=0)
    assert server.on_close() == [PUBLISHED, ReplyResult('get', GoalStatus.ABORTED, None)]
    assert server.on_result(A, 'late', now=0) == []
    statistics = server.statistics()
    assert (statistics.running, statistics.waiting, statistics.aborted) == (0, 0, 2)


# ---- preempting ----


def test_a_new_goal_calls_off_the_one_that_runs_and_starts_when_that_has_ended() -> None:
    server = serving(preempt(), A)
    assert send(server, B) == [PUBLISHED, PUBLISHED, StoppedByServer(A)]
    assert published(server) == {A: GoalStatus.CANCELING, B: GoalStatus.ACCEPTED}
    assert finish(server, A, GoalEvent.CANCELED)[-2:] == [PUBLISHED, Execute(B)]
    assert published(server) == {A: GoalStatus.CANCELED, B: GoalStatus.EXECUTING}


def test_of_the_goals_that_wait_for_a_slow_one_the_latest_alone_is_left() -> None:
    server = serving(preempt(), A, B)
    assert send(server, C) == [PUBLISHED, PUBLISHED, WakeAt(10 * S)]
    assert published(server) == {A: GoalStatus.CANCELING, B: GoalStatus.CANCELED, C: GoalStatus.ACCEPTED}
    assert finish(server, A)[-1] == Execute(C)  # it came to its end all the same
    assert published(server)[A] is GoalStatus.SUCCEEDED


def test_many_goals_in_a_row_leave_one_that_runs() -> None:
    server = Server(0, policy=preempt())
    ids = [bytes([n]) * 16 for n in range(1, 100)]
    for goal_id in ids:
        send(server, goal_id)
    assert finish(server, ids[0], GoalEvent.CANCELED)[-1] == Execute(ids[-1])
    finish(server, ids[-1])
    statistics = server.statistics()
    assert (statistics.retained, statistics.running, statistics.waiting) == (0, 0, 0)
    assert (statistics.accepted, statistics.canceled, statistics.succeeded) == (99, 98, 1)


# ---- clients that go ----


def lost(how: Any, policy: GoalPolicy = QUEUE) -> Server:
    """A server where A (mine) runs, B (yours) and C (mine) wait, and D (mine) is being decided."""
    server = Server(policy=policy, on_client_lost=how)
    send(server, A)
    send(server, B, client=YOU)
    send(server, C)
    server.on_goal_request(D, 'send', now=0, client=ME)
    server.take_status()
    return server


def test_goals_of_a_lost_client_are_kept_by_default() -> None:
    server = lost('keep')
    assert server.on_client_lost(ME, now=0) == []
    assert server.on_goal_decision(D, accepted=True, stamp_ns=S)[0] == ReplyGoal('send', True, S)


def test_goals_of_a_lost_client_are_cancelled() -> None:
    server = lost('cancel')
    effects = server.on_client_lost(ME, now=0)
    assert effects == [*REFUSED, PUBLISHED, StoppedByServer(A), PUBLISHED, WakeAt(10 * S)]
    expected = {A: GoalStatus.CANCELING, B: GoalStatus.ACCEPTED, C: GoalStatus.CANCELED}
    assert published(server) == expected
    assert server.on_goal_decision(D, accepted=True, stamp_ns=S) == []
    assert server.on_client_lost(ME, now=0) == []
    assert finish(server, A, GoalEvent.CANCELED)[-1] == Execute(B)


def test_goals_of_a_lost_client_are_aborted_and_keep_their_place_until_execution_is_over() -> None:
    server = lost('abort')
    effects = server.on_client_lost(ME, now=0)
    assert effects == [*REFUSED, PUBLISHED, StoppedByServer(A), PUBLISHED, WakeAt(10 * S)]
    expected = {A: GoalStatus.ABORTED, B: GoalStatus.ACCEPTED, C: GoalStatus.ABORTED}
    assert published(server) == expected
    with pytest.raises(InvalidTransition):
        finish(server, A)
    assert server.on_result(A, 'late', now=0)[-2:] == [PUBLISHED, Execute(B)]


def test_a_goal_that_is_being_cancelled_is_aborted_with_its_client() -> None:
    server = lost('abort', parallel(9))
    server.on_cancel_request(A, 0, 'cancel', now=0)
    server.on_cancel_decision(0, A, accepted=True, now=0)
    server.on_client_lost(ME, now=0)
    assert server.status(A) is GoalStatus.ABORTED
    assert server.status(B) is GoalStatus.EXECUTING


def test_goals_that_have_ended_stay_as_they_are() -> None:
    server = lost('abort')
    finish(server, A)
    server.on_client_lost(ME, now=0)
    assert server.status(A) is GoalStatus.SUCCEEDED


def test_what_else_may_become_of_a_lost_clients_goals_is_no_choice() -> None:
    with pytest.raises(ValueError, match="'keep' or 'cancel' or 'abort', not 'forget'"):
        Server(on_client_lost='forget')  # type: ignore[arg-type]
