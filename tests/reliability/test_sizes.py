"""Item 14: requests and replies of sizes around a wire's packets, and of megabytes, both ways."""

from __future__ import annotations

from helpers.collector import Collector
from helpers.outcomes import Outcomes
from helpers.wire import Answers, Side

from goalwire.transport.contract import Request, Session

from .conftest import Evidence

SIZES = [0, 1, *range(65_500, 65_540, 13), 65_535, 65_536, 1_000_000, 8_000_000]
"""Zenoh's batches hold 65,535 bytes, UDP's datagrams 65,507; what is larger travels in fragments."""


def test_requests_and_replies_of_any_size_arrive_unchanged(
    session_pair: tuple[Session, Session], evidence: Evidence
) -> None:
    outcomes = Outcomes()
    mission, arm = Side(session_pair[0], 'mission'), Side(session_pair[1], 'arm')
    arrived: Collector[Request] = Collector()

    arm.service('/echo', arrived)
    client = mission.client('/echo')
    mission.expect_server(client, '/echo')
    for number, size in enumerate(SIZES, start=1):
        content = (bytes(range(256)) * (size // 256 + 1))[:size]
        answers = Answers()
        answers.ask(client, content)
        request = arrived.expect(number)[-1]
        assert bytes(request.sample.payload) == content
        request.reply(content[::-1])
        (reply,) = answers.expect(replies=1)
        assert bytes(reply.payload) == content[::-1]
        outcomes.note('done')
    evidence(14, f"sizes of 0 B to {SIZES[-1] // 1_000_000} MB, around a packet's end", outcomes)
