"""A peer that hears nothing for a while: requests and replies all come in the end, and no caller waits."""

from __future__ import annotations

import ctypes
import threading

import pytest
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.wire import Answers, Side

from goalwire.transport.contract import Request
from goalwire.transport.dds.cyclone.abi import INFINITY
from goalwire.transport.dds.cyclone.context import CycloneContext
from goalwire.transport.dds.cyclone.session import CycloneSession

Sides = tuple[Side, Side]
MANY = 300
"""More than a history of a hundred, less than the library takes in unacknowledged."""
SMALL_FLOOD = 2000
"""So many that the library has no room for more, at 100 bytes."""
SOON = 3.0
"""s, less than is left of a lease of 10 s, whose end would set everybody free."""
LARGE = [b'%d ' % number * 1000 for number in range(MANY)]
"""More than the library takes in."""


def let_hear(side: Side, hears: bool) -> None:
    """Have a side take packets in, or lose them; it goes on sending."""
    assert isinstance(side.session, CycloneSession)
    context = side.session._context
    assert isinstance(context, CycloneContext)
    set_deaf_and_mute = ctypes.CDLL(context.library.path).dds_domain_set_deafmute
    set_deaf_and_mute.argtypes = ctypes.c_int32, ctypes.c_bool, ctypes.c_bool, ctypes.c_int64
    assert set_deaf_and_mute(context.participant.handle, not hears, False, INFINITY) == 0


def late_threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == 'goalwire-dds-late']


def join_late_threads() -> None:
    for thread in late_threads():
        thread.join(PATIENCE)
    assert not late_threads()


@pytest.mark.parametrize(
    'contents', [[b'%d' % number for number in range(MANY)], LARGE], ids=['small', 'large']
)
def test_a_client_that_was_deaf_gets_all_of_its_replies_in_order(
    sides_apart: Sides, contents: list[bytes]
) -> None:
    alpha, beta = sides_apart
    asked: Collector[Request] = Collector()
    beta.service('/add', asked)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    answers = Answers()
    for _ in contents:
        answers.ask(client)
    requests = asked.expect(MANY)
    let_hear(alpha, False)
    for request, content in zip(requests, contents, strict=True):
        request.reply(content)
    assert len(late_threads()) == (contents is LARGE)
    let_hear(alpha, True)
    assert [reply.payload for reply in answers.expect(replies=MANY, ends=MANY)] == contents
    join_late_threads()


@pytest.mark.parametrize(
    'contents', [[b'%d' % number for number in range(MANY)], LARGE], ids=['small', 'large']
)
def test_a_server_that_was_deaf_gets_all_requests_in_order(sides_apart: Sides, contents: list[bytes]) -> None:
    alpha, beta = sides_apart
    asked: Collector[Request] = Collector()
    beta.service('/add', asked)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    let_hear(beta, False)
    for content in contents:
        Answers().ask(client, content)
    assert len(late_threads()) == (contents is LARGE)
    let_hear(beta, True)
    assert [request.sample.payload for request in asked.expect(MANY)] == contents
    join_late_threads()


def test_a_client_that_hears_nothing_holds_up_no_other_one(sides_apart: Sides) -> None:
    alpha, beta = sides_apart
    asked: Collector[Request] = Collector()
    beta.service('/add', asked)
    clients = [side.client('/add') for side in sides_apart]
    for side, client in zip(sides_apart, clients, strict=True):
        side.expect_server(client, '/add')
    answers = Answers()
    for _ in range(SMALL_FLOOD):
        answers.ask(clients[0])
    requests = asked.expect(SMALL_FLOOD)
    let_hear(alpha, False)
    for request in requests:
        request.reply(b'x' * 100)
    assert late_threads()
    others = Answers()
    others.ask(clients[1])
    asked.expect(SMALL_FLOOD + 1)[-1].reply(b'yours')
    assert [reply.payload for reply in others.replies.expect(1, SOON)] == [b'yours']
    let_hear(alpha, True)
    join_late_threads()
    back = Answers()
    back.ask(clients[0])
    asked.expect(SMALL_FLOOD + 2)[-1].reply(b'mine')
    assert [reply.payload for reply in back.expect(replies=1, ends=1)] == [b'mine']


def test_what_waits_for_a_server_that_goes_is_not_sent_to_the_next_one(sides_apart: Sides) -> None:
    alpha, beta = sides_apart
    asked: Collector[Request] = Collector()
    server = beta.service('/add', asked)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    let_hear(beta, False)
    answers = Answers()
    for content in LARGE:
        answers.ask(client, content)
    server.close()
    answers.expect(replies=0, ends=MANY)
    let_hear(beta, True)
    beta.service('/add', asked)
    alpha.expect_server(client, '/add')
    answers.ask(client, b'the first of its own')
    assert [request.sample.payload for request in asked.expect(1)] == [b'the first of its own']
    join_late_threads()


def test_closing_ends_what_waits_for_a_peer_that_hears_nothing(sides_apart: Sides) -> None:
    alpha, beta = sides_apart
    beta.service('/add', lambda _: None)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    let_hear(beta, False)
    for content in LARGE:
        Answers().ask(client, content)
    assert late_threads()
    client.close()
    assert not late_threads()
    let_hear(beta, True)
