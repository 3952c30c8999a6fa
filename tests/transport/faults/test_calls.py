"""Faults of calls: requests and replies that are lost, late, doubled; servers that die, or cannot be seen."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from helpers.collector import Collector
from helpers.hand_clock import HandClock
from helpers.patience import wait_for
from helpers.wire import BARE, Answers, ContentClient, Side

from goalwire.errors import LocalError
from goalwire.transport.contract import EndpointKind, Request
from goalwire.transport.faults import Delay, Duplication, Faults, Kill, Kind, Loss, LostReply, Point

from .conftest import Sides

SERVICE, NODE = EndpointKind.SERVICE, EndpointKind.NODE


class Server:
    """Counts what it is asked and answers at once."""

    def __init__(self) -> None:
        self.asked: Collector[Request] = Collector()

    def __call__(self, request: Request) -> None:
        self.asked(request)
        request.reply(b'done')


def connected(sides: Sides, deliver: Callable[[Request], None], name: str = '/add') -> ContentClient:
    """Return a client of alpha's for a service of beta's."""
    sides[1].service(name, deliver)
    client = sides[0].client(name)
    sides[0].graph.expect(SERVICE, name)
    return client


def test_a_lost_request_reaches_nobody_and_nobody_tells(sides: Sides, faults: Faults) -> None:
    faults.add(Loss(kind=Kind.REQUEST, times=1))
    server, answers = Server(), Answers()
    client = connected(sides, server)
    answers.ask(client)
    assert (server.asked.items, answers.reasons) == ([], [])
    answers.ask(client)
    answers.expect(replies=1)


def test_a_lost_reply_leaves_the_handler_run_and_the_client_waiting(sides: Sides, faults: Faults) -> None:
    fault = faults.add(LostReply(times=1))
    server, answers = Server(), Answers()
    client = connected(sides, server)
    answers.ask(client)
    assert (len(server.asked.items), answers.replies.items, answers.reasons) == (1, [], [])
    assert fault.struck == 1
    with pytest.raises(LocalError, match='answered before'):
        server.asked.items[0].reply(b'again')


def test_the_end_of_a_server_ends_the_calls_whose_replies_were_lost(sides: Sides, faults: Faults) -> None:
    faults.add(LostReply())
    answers = Answers()
    answers.ask(connected(sides, Server()))
    sides[1].session.close()
    answers.expect(replies=0)


def test_a_doubled_request_runs_the_handler_twice_and_is_answered_once(sides: Sides, faults: Faults) -> None:
    faults.add(Duplication())
    server, answers = Server(), Answers()
    answers.ask(connected(sides, server))
    answers.expect(replies=1)
    first, second = server.asked.items
    assert (first.sample.gid, first.sample.sequence) == (second.sample.gid, second.sample.sequence)


def test_a_doubled_request_is_given_up_only_by_both(sides: Sides, faults: Faults) -> None:
    faults.add(Duplication())
    requests: Collector[Request] = Collector()
    answers = Answers()
    answers.ask(connected(sides, requests))
    first, second = requests.expect(2)
    first.cancel('no time')
    assert answers.reasons == []
    second.cancel('neither')
    answers.expect(replies=0)
    assert answers.reasons == ['neither']


def test_requests_and_replies_travel_for_as_long_as_the_delay(
    sides: Sides, faults: Faults, clock: HandClock
) -> None:
    faults.add(Delay(1.0))
    server, answers = Server(), Answers()
    answers.ask(connected(sides, server))
    clock.advance(1.0)
    server.asked.expect(1)
    wait_for(lambda: faults.under_way == 1, 'the reply')  # the server replies after it has noted the request
    assert answers.replies.items == []
    clock.advance(1.0)
    answers.expect(replies=1)


def test_a_forgotten_call_is_never_heard_of_again(sides: Sides, faults: Faults) -> None:
    requests: Collector[Request] = Collector()
    answers = Answers()
    client = connected(sides, requests)
    client.cancel(answers.ask(client))
    requests.items[0].reply(b'late')
    assert (answers.replies.items, answers.reasons) == ([], [])


# -- partitions --------------------------------------------------------------------------------------------


def test_a_partition_is_noticed_when_the_lease_ends_and_forgotten_when_it_heals(
    sides: Sides, faults: Faults, clock: HandClock
) -> None:
    alpha, beta = sides
    server, answers = Server(), Answers()
    client = connected(sides, server)
    faults.partition('alpha', 'beta', lease=10.0)
    answers.ask(client)
    clock.advance(9.9)
    assert (server.asked.items, answers.reasons) == ([], [])
    alpha.graph.expect(NODE, '/beta')
    clock.advance(0.1)
    answers.expect(replies=0)
    alpha.graph.expect(NODE, '/beta', 0)
    alpha.graph.expect(SERVICE, '/add', 0)
    beta.graph.expect(NODE, '/alpha', 0)
    assert alpha.graph.now(NODE, '/alpha')
    answers.ask(client)
    answers.expect(replies=0, ends=2)
    faults.heal()
    alpha.graph.expect(SERVICE, '/add')
    beta.graph.expect(NODE, '/alpha')
    answers.ask(client)
    answers.expect(replies=1, ends=3)


def test_who_is_not_heard_is_lost_from_sight_and_still_sees_the_others(sides: Sides, faults: Faults) -> None:
    faults.partition('beta', 'alpha', one_way=True, lease=0.0)
    sides[0].graph.expect(NODE, '/beta', 0)
    sides[1].graph.expect(NODE, '/alpha')


def test_whoever_comes_and_goes_behind_a_partition_is_seen_as_it_is_when_it_heals(
    sides: Sides, faults: Faults
) -> None:
    alpha, beta = sides
    beta.publisher('/old')
    faults.partition('alpha', lease=0.0)
    alpha.graph.expect(EndpointKind.PUBLISHER, '/old', 0)
    going = beta.publisher('/going')
    beta.publisher('/coming')
    going.close()
    assert alpha.graph.now(EndpointKind.PUBLISHER) == []
    faults.heal()
    assert {entity.name for entity in alpha.graph.now(EndpointKind.PUBLISHER)} == {'/old', '/coming'}


def test_the_end_of_the_last_session_takes_a_partition_that_nobody_has_noticed_with_it(
    sides: Sides, faults: Faults
) -> None:
    faults.partition('alpha', lease=1000.0)
    assert faults.under_way == 1
    for side in sides:
        side.session.close()
    assert faults.under_way == 0


# -- deaths ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(('point', 'asked'), [(Point.REQUEST_RECEIVED, 1), (Point.HANDLER_DONE, 2)])
def test_a_server_that_dies_at_a_point_ends_its_calls_and_vanishes(
    sides: Sides, faults: Faults, clock: HandClock, point: Point, asked: int
) -> None:
    fault = faults.add(Kill('beta', point, '/add', nth=2))
    server, answers = Server(), Answers()
    client = connected(sides, server)
    answers.ask(client)
    answers.expect(replies=1)
    answers.ask(client)
    answers.expect(replies=1, ends=2)
    sides[0].graph.expect(NODE, '/beta', 0)
    assert len(server.asked.items) == asked
    assert fault.struck == 1
    assert set(faults.dead) == {'/beta'}


def test_nothing_leaves_a_dead_node(sides: Sides, faults: Faults) -> None:
    alpha, beta = sides
    faults.add(Kill('beta', Point.MESSAGE_SENT, '/chatter', nth=3))
    heard: Collector[object] = Collector()
    alpha.subscription('/chatter', heard)
    publisher = beta.publisher('/chatter')
    for _ in range(5):
        publisher.publish(b'alive')
    alpha.graph.expect(NODE, '/beta', 0)
    assert len(heard.items) == 3


def test_a_node_that_was_killed_can_be_made_again(sides: Sides, faults: Faults) -> None:
    alpha, beta = sides
    faults.add(Kill('beta', Point.REQUEST_RECEIVED))
    answers = Answers()
    client = connected(sides, Server())
    answers.ask(client)
    answers.expect(replies=0)
    alpha.graph.expect(NODE, '/beta', 0)
    again = Side(beta.session, 'beta', BARE)
    again.service('/add', Server())
    alpha.graph.expect(SERVICE, '/add')
    answers.ask(client)
    answers.expect(replies=1, ends=2)


@pytest.mark.parametrize(('accepted', 'dies'), [(1, True), (0, False)])
def test_a_goal_that_was_refused_was_not_accepted(
    sides: Sides, faults: Faults, accepted: int, dies: bool
) -> None:
    fault = faults.add(Kill('beta', Point.GOAL_ACCEPTED, '/move'))
    answers = Answers()
    reply = bytes([0, 1, 0, 0, accepted])
    client = connected(sides, lambda request: request.reply(reply), '/move/_action/send_goal')
    answers.ask(client)
    answers.expect(replies=1)
    assert fault.struck == dies
