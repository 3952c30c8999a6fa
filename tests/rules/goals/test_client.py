from __future__ import annotations

import pytest

from goalwire.errors import GoalIdTaken
from goalwire.rules.goals import GoalClient, GoalStatus, new_goal_id
from goalwire.rules.goals.client import REMEMBERED
from goalwire.rules.goals.effects import (
    DeliverResult,
    FailResult,
    GoalAccepted,
    GoalRejected,
    RequestResult,
    StatusChanged,
    UnexpectedReply,
)
from goalwire.rules.goals.status_array import StatusArray

A, B = (bytes([n]) * 16 for n in range(1, 3))

Client = GoalClient[str, str]


class Feedback:
    """A queue of feedback."""

    dropped = 0

    def deliver(self, event: object) -> None:
        raise AssertionError(event)  # the rules hand it out and call nothing of it

    def close(self) -> None:
        return


def array(*goals: tuple[bytes, GoalStatus]) -> bytes:
    """Return a status array as servers send it."""
    made = StatusArray()
    for goal_id, status in goals:
        made.add(goal_id, 1, status)
    return made.encode()


def with_goal(goal_id: bytes = A) -> Client:
    client = Client()
    client.on_send(goal_id)
    client.on_goal_reply(goal_id, accepted=True)
    return client


def test_a_goal_is_sent_accepted_followed_and_ended() -> None:
    client = Client()
    client.on_send(A)
    assert client.on_goal_reply(A, accepted=True) == [GoalAccepted(A, GoalStatus.UNKNOWN)]
    assert client.on_result_request(A, 'waiter') == [RequestResult(A)]
    assert client.on_status(array((A, GoalStatus.EXECUTING))) == [StatusChanged(A, GoalStatus.EXECUTING)]
    assert client.on_status(array((A, GoalStatus.SUCCEEDED))) == [StatusChanged(A, GoalStatus.SUCCEEDED)]
    assert client.on_result(A, GoalStatus.SUCCEEDED, 'done') == [
        DeliverResult('waiter', GoalStatus.SUCCEEDED, 'done')
    ]
    assert client.status(A) is GoalStatus.SUCCEEDED


def test_a_rejected_goal_is_discarded() -> None:
    client = Client()
    client.on_send(A)
    assert client.on_goal_reply(A, accepted=False) == [GoalRejected(A)]
    assert client.find(A) is None
    client.on_send(A)


def test_who_waits_for_a_result_is_told_though_a_second_goal_of_that_id_is_rejected() -> None:
    client = Client()
    client.on_send(A)
    client.on_result_request(A, 'waiter')  # by the handle of an older goal
    assert client.on_goal_reply(A, accepted=False) == [GoalRejected(A)]
    assert client.on_result(A, GoalStatus.ABORTED, 'old') == [
        StatusChanged(A, GoalStatus.ABORTED),
        DeliverResult('waiter', GoalStatus.ABORTED, 'old'),
    ]
    assert client.statistics().waiting_for_results == 0


def test_an_id_under_way_cannot_be_used_again() -> None:
    client = with_goal()
    with pytest.raises(GoalIdTaken, match=A.hex()):
        client.on_send(A)


def test_an_answer_nobody_waits_for_is_noted() -> None:
    client = with_goal()
    assert client.on_goal_reply(A, accepted=True) == [UnexpectedReply(A)]
    assert client.on_goal_reply(B, accepted=True) == [UnexpectedReply(B)]


def test_feedback_goes_to_its_goal_from_the_moment_that_is_sent() -> None:
    client, queue = Client(), Feedback()
    goal = client.on_send(A, queue)
    assert client.find(A) is goal
    assert goal.feedback is queue
    client.on_goal_reply(A, accepted=True)
    assert client.find(A) is goal


def test_feedback_for_other_clients_goals_finds_none() -> None:
    assert with_goal().find(B) is None


def test_feedback_overtaken_by_the_result_finds_its_goal() -> None:
    client, queue = Client(), Feedback()
    goal = client.on_send(A, queue)
    client.on_goal_reply(A, accepted=True)
    client.on_result_request(A, 'waiter')
    client.on_result(A, GoalStatus.SUCCEEDED, 'done')
    assert client.find(A) is goal
    assert client.feedback_queues() == [queue]


def test_feedback_that_was_dropped_is_counted_when_its_goal_is_no_longer_remembered() -> None:
    client = Client()
    for number in range(REMEMBERED + 5):
        goal_id, queue = number.to_bytes(16, 'little'), Feedback()
        queue.dropped = 2
        client.on_send(goal_id, queue)
        client.on_goal_reply(goal_id, accepted=True)
        client.on_status(array((goal_id, GoalStatus.SUCCEEDED)))
    assert len(client.feedback_queues()) == REMEMBERED
    assert client.feedback_dropped == 2 * (REMEMBERED + 5)


def test_a_status_before_the_acceptance_is_known_with_it() -> None:
    client = Client()
    client.on_send(A)
    client.on_status(array((A, GoalStatus.EXECUTING)))
    assert client.on_goal_reply(A, accepted=True) == [GoalAccepted(A, GoalStatus.EXECUTING)]


def test_a_goal_that_ended_before_the_acceptance_is_known_is_accepted_all_the_same() -> None:
    client = Client()
    client.on_send(A)
    client.on_status(array((A, GoalStatus.SUCCEEDED)))
    assert client.on_goal_reply(A, accepted=True) == [GoalAccepted(A, GoalStatus.SUCCEEDED)]
    assert client.statistics().active == 0


def test_a_result_before_the_acceptance_is_delivered() -> None:
    client = Client()
    client.on_send(A)
    client.on_result_request(A, 'waiter')
    assert client.on_result(A, GoalStatus.SUCCEEDED, 'done') == [
        StatusChanged(A, GoalStatus.SUCCEEDED),
        DeliverResult('waiter', GoalStatus.SUCCEEDED, 'done'),
    ]
    assert client.on_goal_reply(A, accepted=True) == [GoalAccepted(A, GoalStatus.SUCCEEDED)]


def test_a_status_never_goes_back() -> None:
    client = with_goal()
    client.on_status(array((A, GoalStatus.CANCELING)))
    assert client.on_status(array((A, GoalStatus.EXECUTING))) == []
    assert client.on_status(array((A, GoalStatus.CANCELING))) == []
    assert client.status(A) is GoalStatus.CANCELING


def test_a_terminal_status_is_final() -> None:
    client = with_goal()
    client.on_result_request(A, 'waiter')
    client.on_status(array((A, GoalStatus.SUCCEEDED)))
    assert client.on_status(array((A, GoalStatus.ABORTED))) == []
    assert client.status(A) is GoalStatus.SUCCEEDED


def test_statuses_of_other_clients_goals_are_ignored() -> None:
    client = with_goal()
    assert client.on_status(array((B, GoalStatus.EXECUTING), (A, GoalStatus.EXECUTING))) == [
        StatusChanged(A, GoalStatus.EXECUTING)
    ]
    assert client.status(B) is GoalStatus.UNKNOWN


def test_the_result_tells_the_status_where_no_array_came() -> None:
    client = with_goal()
    client.on_result_request(A, 'waiter')
    assert client.on_result(A, GoalStatus.CANCELED, 'partly') == [
        StatusChanged(A, GoalStatus.CANCELED),
        DeliverResult('waiter', GoalStatus.CANCELED, 'partly'),
    ]


def test_several_who_wait_for_a_result_share_one_request() -> None:
    client = with_goal()
    assert client.on_result_request(A, 'first') == [RequestResult(A)]
    assert client.on_result_request(A, 'second') == []
    assert client.on_result(A, GoalStatus.SUCCEEDED, 'done')[1:] == [
        DeliverResult('first', GoalStatus.SUCCEEDED, 'done'),
        DeliverResult('second', GoalStatus.SUCCEEDED, 'done'),
    ]


def test_a_result_may_be_asked_for_again() -> None:
    client = with_goal()
    client.on_result_request(A, 'first')
    client.on_result(A, GoalStatus.SUCCEEDED, 'done')
    assert client.on_result_request(A, 'again') == [RequestResult(A)]
    assert client.on_result(A, GoalStatus.SUCCEEDED, 'done') == [
        DeliverResult('again', GoalStatus.SUCCEEDED, 'done')
    ]


def test_an_expired_result_is_delivered_as_unknown_and_changes_no_status() -> None:
    client = with_goal()
    client.on_status(array((A, GoalStatus.SUCCEEDED)))
    client.on_result_request(A, 'late')
    assert client.on_result(A, GoalStatus.UNKNOWN, 'default') == [
        DeliverResult('late', GoalStatus.UNKNOWN, 'default')
    ]
    assert client.status(A) is GoalStatus.SUCCEEDED


def test_a_failed_result_request_leaves_the_goal_under_way() -> None:
    client = with_goal()
    client.on_result_request(A, 'waiter')
    error = TimeoutError()
    assert client.on_result_failed(A, error) == [FailResult('waiter', error)]
    assert client.on_status(array((A, GoalStatus.EXECUTING))) == [StatusChanged(A, GoalStatus.EXECUTING)]
    assert client.on_result_request(A, 'again') == [RequestResult(A)]


def test_goals_of_servers_that_were_killed_are_forgotten() -> None:
    client = Client()
    for number in range(1000):
        goal_id = number.to_bytes(16, 'little')
        client.on_send(goal_id)
        client.on_goal_reply(goal_id, accepted=True)
        client.on_result_request(goal_id, 'waiter')
        client.on_result_failed(goal_id, TimeoutError())
    held = client.statistics()
    assert (held.unanswered, held.active, held.remembered, held.waiting_for_results) == (0, 0, REMEMBERED, 0)


def test_a_goal_that_is_never_answered_is_given_up() -> None:
    client = Client()
    client.on_send(A)
    client.on_result_request(A, 'waiter')
    error = TimeoutError()
    assert client.on_send_failed(A, error) == [FailResult('waiter', error)]
    assert client.on_send_failed(A, error) == []
    assert client.on_goal_reply(A, accepted=True) == [UnexpectedReply(A)]


def test_closing_fails_all_who_wait() -> None:
    client = with_goal()
    client.on_result_request(A, 'first')
    client.on_result_request(A, 'second')
    error = RuntimeError()
    assert client.on_close(error) == [FailResult('first', error), FailResult('second', error)]
    assert client.on_close(error) == []


def test_tables_are_bounded() -> None:
    client = Client()
    for _ in range(3 * REMEMBERED):
        goal_id = new_goal_id()
        client.on_send(goal_id)
        client.on_goal_reply(goal_id, accepted=True)
        client.on_status(array((goal_id, GoalStatus.SUCCEEDED)))
    statistics = client.statistics()
    assert (statistics.unanswered, statistics.active, statistics.remembered) == (0, 0, REMEMBERED)
    assert client.find(goal_id) is not None


def test_a_result_that_nobody_waits_for_any_more_is_given_up_with_the_last_who_did() -> None:
    client = with_goal()
    client.on_result_request(A, 'first')
    client.on_result_request(A, 'second')
    client.active[A].request = 'request'
    assert client.on_result_cancelled(A, 'first') is None
    assert client.on_result_cancelled(A, 'first') is None
    assert client.active[A].waiters == ['second']
    assert client.on_result_cancelled(A, 'second') == 'request'
    assert A not in client.active
    assert client.statistics().active == 0
    assert client.on_status(array((A, GoalStatus.EXECUTING))) == [StatusChanged(A, GoalStatus.EXECUTING)]
    assert client.on_result_request(A, 'third') == [RequestResult(A)]
