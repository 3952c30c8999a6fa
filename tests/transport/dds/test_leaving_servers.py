"""A server that ends takes its reader of requests away first; its last replies arrive all the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import pytest
from helpers.collector import Collector
from helpers.isolation import fresh_domain
from helpers.wire import Answers, Side

from goalwire.transport.contract import Request, SessionOptions
from goalwire.transport.dds import CHOICE, NATIVE, TRANSPORTS
from goalwire.transport.dds.native.service import NativeService


class LeavingServer(NamedTuple):
    """A server whose reader of requests has gone, seen by a client that it has yet to answer."""

    request: Request
    answers: Answers
    delete_writer: Callable[[], None]


@pytest.fixture
def leaving(monkeypatch: pytest.MonkeyPatch) -> Iterator[LeavingServer]:
    monkeypatch.setenv(CHOICE, NATIVE)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    options = SessionOptions(fresh_domain())
    sessions = [TRANSPORTS['rmw_cyclonedds_cpp'].open(options) for _ in range(2)]
    try:
        calling, serving = Side(sessions[0], 'calling'), Side(sessions[1], 'serving')
        requests: Collector[Request] = Collector()
        service = serving.service('/add', requests)
        client = calling.client('/add')
        calling.expect_server(client, '/add')
        answers = Answers()
        answers.ask(client)
        (request,) = requests.expect(1)
        assert isinstance(service, NativeService)
        participant = service._context.participant
        participant.delete(service._reader)
        calling.graph.wait_for(lambda: not client.reaches_server())
        yield LeavingServer(request, answers, lambda: participant.delete(service._writer))
    finally:
        for session in reversed(sessions):
            session.close()


def test_a_reply_arrives_although_the_servers_reader_has_gone(leaving: LeavingServer) -> None:
    leaving.request.reply(b'the last one')
    assert [reply.payload for reply in leaving.answers.expect(1)] == [b'the last one']


def test_a_call_ends_once_the_servers_writer_has_gone_too(leaving: LeavingServer) -> None:
    leaving.delete_writer()
    assert leaving.answers.expect(replies=0) == []
