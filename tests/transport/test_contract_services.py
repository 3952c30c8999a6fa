"""Services and clients: what every transport must do."""

from __future__ import annotations

import threading
from collections.abc import Callable

from helpers.collector import Collector
from helpers.wire import Answers, ContentClient, Side

from goalwire.transport.contract import EndpointKind, Port, Request, Sample, Session

SERVICE = EndpointKind.SERVICE

Requests = Collector[Request]
Sides = tuple[Side, Side]


def echo(request: Request) -> None:
    request.reply(b'echo ' + bytes(request.sample.payload))


def nothing(_: str) -> None:
    """Take note of an end that no test asks about."""


def connected(sides: Sides, deliver: Callable[[Request], None]) -> tuple[ContentClient, Port]:
    """Return a client of the first side that a server of the second side can hear, and that server."""
    alpha, beta = sides
    server = beta.service('/add', deliver)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    return client, server


def test_a_request_reaches_a_server_and_its_reply_comes_back(sides: Sides) -> None:
    answers = Answers()
    client, _ = connected(sides, echo)
    answers.ask(client, b'1 + 1')
    (reply,) = answers.expect(replies=1)
    assert bytes(reply.payload) == b'echo 1 + 1'


def test_a_client_may_come_before_the_server(sides: Sides) -> None:
    alpha, beta = sides
    answers = Answers()
    client = alpha.client('/add')
    beta.graph.expect(EndpointKind.CLIENT, '/add')
    beta.service('/add', echo)
    alpha.expect_server(client, '/add')
    answers.ask(client)
    answers.expect(replies=1)


def test_client_and_server_may_share_a_session(sides: Sides) -> None:
    alpha, _ = sides
    answers = Answers()
    alpha.service('/add', echo)
    answers.ask(alpha.client('/add'))
    answers.expect(replies=1)


def test_requests_are_counted_and_replies_name_their_request(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    assert [answers.ask(client) for _ in range(3)] == [1, 2, 3]
    arrived = requests.expect(3)
    assert sorted(request.sample.sequence for request in arrived) == [1, 2, 3]
    assert {request.sample.gid for request in arrived} == {client.gid}
    for request in arrived:
        request.reply(b'%d' % request.sample.sequence)
    for reply in answers.expect(replies=3, ends=3):
        assert bytes(reply.payload) == b'%d' % reply.sequence
        assert reply.gid == client.gid


def test_thirty_two_requests_in_flight_each_get_their_own_reply(sides: Sides) -> None:
    requests = Requests()
    client, _ = connected(sides, requests)
    calls = [Answers() for _ in range(32)]
    for number, answers in enumerate(calls):
        answers.ask(client, b'%d' % number)
    for request in reversed(requests.expect(32)):
        echo(request)
    for number, answers in enumerate(calls):
        (reply,) = answers.expect(replies=1)
        assert bytes(reply.payload) == b'echo %d' % number


def test_a_reply_may_come_from_any_thread_at_any_time(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    (request,) = requests.expect(1)
    thread = threading.Thread(target=echo, args=(request,))
    thread.start()
    thread.join()
    answers.expect(replies=1)


def test_several_servers_all_answer_and_the_request_ends_once(sides: Sides) -> None:
    alpha, beta = sides
    answers = Answers()
    beta.service('/add', lambda request: request.reply(b'first'))
    beta.service('/add', lambda request: request.reply(b'second'))
    client = alpha.client('/add')
    alpha.expect_server(client, '/add', 2)
    answers.ask(client)
    replies = answers.expect(replies=2)
    assert {bytes(reply.payload) for reply in replies} == {b'first', b'second'}
    assert answers.replies_before_each_end == [2]


def test_a_server_that_gives_up_does_not_end_a_request_another_still_has(sides: Sides) -> None:
    alpha, beta = sides
    requests, answers = Requests(), Answers()
    beta.service('/add', requests)
    beta.service('/add', lambda request: request.cancel())
    client = alpha.client('/add')
    alpha.expect_server(client, '/add', 2)
    answers.ask(client)
    echo(requests.expect(1)[0])
    answers.expect(replies=1)
    assert answers.replies_before_each_end == [1]


def test_a_request_to_nobody_ends_at_once_without_a_reply(sides: Sides) -> None:
    answers = Answers()
    answers.ask(sides[0].client('/nobody'))
    answers.expect(replies=0)


def test_a_request_that_is_dropped_ends_without_a_reply(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    requests.expect(1)[0].cancel()
    answers.expect(replies=0)
    assert answers.reasons == ['']


def test_the_reason_for_dropping_a_request_reaches_its_client(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    requests.expect(1)[0].cancel('no time')
    answers.expect(replies=0)
    assert answers.reasons == ['no time']


def test_dropping_an_answered_request_is_harmless(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    (request,) = requests.expect(1)
    echo(request)
    request.cancel()
    request.cancel()
    answers.expect(replies=1)


def test_a_server_that_closes_ends_its_requests(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, server = connected(sides, requests)
    answers.ask(client)
    answers.ask(client)
    requests.expect(2)
    server.close()
    answers.expect(replies=0, ends=2)


def test_a_request_that_is_forgotten_is_never_heard_of_again(sides: Sides) -> None:
    requests, forgotten, answers = Requests(), Answers(), Answers()
    client, server = connected(sides, requests)
    for _ in range(3):
        client.cancel(forgotten.ask(client))
    answers.ask(client)
    arrived = requests.expect(4)
    for request in arrived:
        echo(request)
    (reply,) = answers.expect(replies=1)
    client.cancel(reply.sequence)  # it has ended
    client.cancel(99)
    server.close()
    assert forgotten.replies.items == []
    assert forgotten.reasons == []


def test_a_session_that_closes_ends_the_requests_of_its_servers(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    requests.expect(1)
    sides[1].session.close()
    answers.expect(replies=0)


def test_a_reply_after_the_server_has_closed_goes_nowhere(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, server = connected(sides, requests)
    answers.ask(client)
    (request,) = requests.expect(1)
    server.close()
    request.reply(b'too late')
    answers.expect(replies=0)


def test_a_client_that_closes_ends_its_requests(sides: Sides) -> None:
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    (request,) = requests.expect(1)
    client.close()
    answers.expect(replies=0)
    request.reply(b'nobody is there to hear it')
    assert answers.replies.items == []


def test_a_reply_to_a_session_that_has_gone_is_no_error(sides: Sides) -> None:
    alpha, beta = sides
    requests, answers = Requests(), Answers()
    client, _ = connected(sides, requests)
    answers.ask(client)
    (request,) = requests.expect(1)
    alpha.session.close()
    beta.graph.expect(EndpointKind.CLIENT, '/add', 0)
    request.reply(b'nobody is there to hear it')


def test_a_server_may_call_another_service_of_its_session_while_it_is_asked(sides: Sides) -> None:
    _, beta = sides
    beta.service('/inner', echo)
    inner = beta.client('/inner')

    def relay(request: Request) -> None:
        inner.request(
            bytes(request.sample.payload), lambda reply: request.reply(bytes(reply.payload)), nothing
        )

    answers = Answers()
    client, _ = connected(sides, relay)
    answers.ask(client, b'hello')
    (reply,) = answers.expect(replies=1)
    assert bytes(reply.payload) == b'echo hello'


def test_a_new_request_may_be_sent_while_a_reply_is_delivered(sides: Sides) -> None:
    client, _ = connected(sides, echo)
    answers = Answers()

    def ask_again(reply: Sample) -> None:
        answers.ask(client, bytes(reply.payload))

    client.request(b'first', ask_again, nothing)
    (reply,) = answers.expect(replies=1)
    assert bytes(reply.payload) == b'echo echo first'


def test_many_threads_may_share_one_client(sides: Sides) -> None:
    answers = Answers()
    client, _ = connected(sides, echo)
    threads = [threading.Thread(target=lambda: [answers.ask(client) for _ in range(50)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    replies = answers.expect(replies=200, ends=200)
    assert sorted(reply.sequence for reply in replies) == list(range(1, 201))


def test_a_call_crosses_while_the_other_side_calls_back(sides: Sides) -> None:
    alpha, beta = sides
    alpha.service('/back', echo)
    back = beta.client('/back')
    beta.expect_server(back, '/back')

    def call_back(request: Request) -> None:
        back.request(b'back', lambda reply: request.reply(bytes(reply.payload)), nothing)

    answers = Answers()
    client, _ = connected(sides, call_back)
    answers.ask(client)
    (reply,) = answers.expect(replies=1)
    assert bytes(reply.payload) == b'echo back'


def test_a_server_that_comes_back_is_reached_again(sides: Sides, open_session: Callable[[], Session]) -> None:
    alpha, _ = sides
    client, server = connected(sides, echo)
    server.close()
    alpha.graph.expect(SERVICE, '/add', 0)
    newcomer = Side(open_session(), 'gamma')
    newcomer.service('/add', echo)
    alpha.expect_server(client, '/add', 1)
    answers = Answers()
    answers.ask(client)
    answers.expect(replies=1)
