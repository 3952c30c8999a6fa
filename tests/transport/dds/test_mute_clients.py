"""A client that takes nothing holds up nobody else, on goalwire's own session."""

from __future__ import annotations

import pytest
from helpers.collector import Collector
from helpers.isolation import fresh_domain
from helpers.wire import Answers, Side

from goalwire.rtps.protocol.writer import MOST_UNACKNOWLEDGED
from goalwire.transport.contract import Request, SessionOptions
from goalwire.transport.dds import CHOICE, NATIVE, TRANSPORTS


@pytest.mark.slow
def test_a_client_that_acknowledges_nothing_delays_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CHOICE, NATIVE)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    domain = fresh_domain()
    transport = TRANSPORTS['rmw_connextdds']  # whose lease of 100 s frees nobody
    sessions = [transport.open(SessionOptions(domain)) for _ in range(3)]
    try:
        mute, good, serving = (
            Side(session, name) for session, name in zip(sessions, ('mute', 'good', 'serving'), strict=True)
        )
        requests: Collector[Request] = Collector()
        serving.service('/add', requests)
        clients = []
        for side in (mute, good):
            clients.append(side.client('/add'))
            side.expect_server(clients[-1], '/add')
        Answers().ask(clients[0])
        (request,) = requests.expect(1)
        context = sessions[0]._context  # type: ignore[attr-defined]
        context.rtps.participant.send_packet = lambda *_: None  # it hears, and says nothing any more
        request.reply(b'')
        for number in range(MOST_UNACKNOWLEDGED + 100):
            answers = Answers()
            answers.ask(clients[1])
            requests.expect(number + 2)[-1].reply(b'')
            answers.expect(replies=1)
    finally:
        for session in reversed(sessions):
            session.close()
