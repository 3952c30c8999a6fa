"""What the memory transport promises of services beyond the contract."""

from __future__ import annotations

import threading

import pytest
from helpers.wire import Answers, Side

from goalwire.errors import LocalError
from goalwire.logging import LogRecord
from goalwire.transport.contract import Request

Sides = tuple[Side, Side]


def test_a_request_is_answered_once(sides: Sides) -> None:
    alpha, beta = sides
    requests: list[Request] = []
    beta.service('/add', requests.append)
    answers = Answers()
    answers.ask(alpha.client('/add'))
    requests[0].reply(b'first')
    with pytest.raises(LocalError, match='/add'):
        requests[0].reply(b'second')
    answers.expect(replies=1)


def test_a_server_that_raises_is_logged_and_ends_the_request(sides: Sides, records: list[LogRecord]) -> None:
    alpha, beta = sides

    def fail(_: Request) -> None:
        raise ZeroDivisionError

    beta.service('/add', fail)
    answers = Answers()
    answers.ask(alpha.client('/add'))
    answers.expect(replies=0)
    assert "service '/add'" in records[-1].message


def test_a_client_callback_that_raises_harms_neither_the_server_nor_the_end(
    sides: Sides, records: list[LogRecord]
) -> None:
    alpha, beta = sides
    ends: list[int] = []

    def fail(_: object) -> None:
        raise ZeroDivisionError

    beta.service('/add', lambda request: request.reply(b''))
    alpha.client('/add').request(b'', fail, lambda _: ends.append(1))
    assert ends == [1]
    assert "client '/add'" in records[-1].message


def test_every_request_ends_once_whatever_closes_when(sides: Sides) -> None:
    alpha, beta = sides
    for _ in range(100):
        requests: list[Request] = []
        servers = [beta.service('/add', requests.append) for _ in range(2)]
        client = alpha.client('/add')
        answers = Answers()
        answers.ask(client)
        racers = [
            threading.Thread(target=servers[0].close),
            threading.Thread(target=client.close),
            *(threading.Thread(target=request.reply, args=(b'',)) for request in requests),
        ]
        for racer in racers:
            racer.start()
        for racer in racers:
            racer.join()
        servers[1].close()
        assert len(answers.replies_before_each_end) == 1
