"""A client's calls, and the servers that go."""

from __future__ import annotations

import threading

from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.wire import Answers, Side

from goalwire.transport.contract import EndpointKind, Request


def test_an_answer_that_came_before_its_server_went_is_taken_first(sides_apart: tuple[Side, Side]) -> None:
    """The program is busy in a callback when the answer comes: the thread that waits on the wire is held."""
    alpha, beta = sides_apart
    asked: Collector[Request] = Collector()
    server = beta.service('/add', asked)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    busy, free = threading.Event(), threading.Event()

    def stay(_sample: object) -> None:
        busy.set()
        free.wait(PATIENCE)

    alpha.subscription('/work', stay)
    publisher = beta.publisher('/work')
    beta.graph.expect(EndpointKind.SUBSCRIPTION, '/work')
    answers = Answers()
    answers.ask(client)
    request = asked.expect(1)[0]
    while not busy.wait(0.05):  # the first messages may come before the two have met
        publisher.publish(b'work')
    try:
        request.reply(b'the answer')
        server.close()
        replies = answers.expect(replies=1, ends=1)
    finally:
        free.set()
    assert [reply.payload for reply in replies] == [b'the answer']
