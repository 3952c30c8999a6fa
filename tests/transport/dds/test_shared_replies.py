"""Clients of one service in a session share a reader of replies; each gets its own, and each counts."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from helpers.collector import Collector
from helpers.isolation import fresh_domain
from helpers.wire import Answers, Side

from goalwire.rtps.io.addresses import Reach
from goalwire.rtps.io.session import RtpsSession, Settings
from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.discovery import ParticipantListener
from goalwire.rtps.protocol.primitives import is_writer
from goalwire.rtps.protocol.qos import BEST_EFFORT
from goalwire.transport.contract import Request, SessionOptions
from goalwire.transport.dds import CHOICE, NATIVE, TRANSPORTS

REPLIES = 'rr/addReply'


class Onlooker(ParticipantListener):
    """A participant that counts clients as rmw_count_clients does: by their readers of replies."""

    def __init__(self) -> None:
        self._readers: dict[bytes, EndpointData] = {}
        self._seen: Collector[list[EndpointData]] = Collector()

    def on_endpoint(self, endpoint: EndpointData) -> None:
        if endpoint.topic == REPLIES and not is_writer(endpoint.entity_id):
            self._readers[endpoint.guid] = endpoint
            self._seen(list(self._readers.values()))

    def on_endpoint_lost(self, endpoint: EndpointData) -> None:
        if self._readers.pop(endpoint.guid, None) is not None:
            self._seen(list(self._readers.values()))

    def expect(self, number: int) -> list[EndpointData]:
        """Wait until there are so many, and return them."""
        return self._seen.wait_for(lambda seen: bool(seen) and len(seen[-1]) == number)[-1]


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setenv(CHOICE, NATIVE)
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    return fresh_domain()


@pytest.fixture
def side(domain: int) -> Iterator[Callable[[str], Side]]:
    """Opens a session with a node of that name."""
    sessions = []

    def open_side(name: str) -> Side:
        sessions.append(TRANSPORTS['rmw_fastrtps_cpp'].open(SessionOptions(domain)))
        return Side(sessions[-1], name)

    yield open_side
    for session in reversed(sessions):
        session.close()


@pytest.fixture
def onlooker(domain: int) -> Iterator[Onlooker]:
    listener = Onlooker()
    session = RtpsSession(Settings(domain=domain, reach=Reach.LOCALHOST), listener)
    yield listener
    session.close()


@pytest.mark.parametrize('is_local', [False, True], ids=['another process', 'the same session'])
def test_each_client_gets_the_replies_to_its_own_requests(
    side: Callable[[str], Side], is_local: bool
) -> None:
    calling = side('calling')
    serving = calling if is_local else side('serving')
    requests: Collector[Request] = Collector()
    serving.service('/add', requests)
    clients = [calling.client('/add') for _ in range(3)]
    asked = [Answers() for _ in clients]
    for client, answers in zip(clients, asked, strict=True):
        calling.expect_server(client, '/add')
        answers.ask(client, client.gid)  # the first request of each has the same number
    for request in reversed(requests.expect(3)):
        request.reply(bytes(request.sample.payload))
    replies = [answers.expect(1)[0].payload for answers in asked]
    assert replies == [client.gid for client in clients]


def test_others_count_each_client_and_only_one_reader_is_reliable(
    side: Callable[[str], Side], onlooker: Onlooker
) -> None:
    calling = side('calling')
    clients = [calling.client('/add')]
    (shared,) = onlooker.expect(1)
    clients += [calling.client('/add') for _ in range(2)]
    readers = onlooker.expect(3)
    unread = [reader for reader in readers if reader.guid != shared.guid]
    assert {reader.qos.reliability for reader in unread} == {BEST_EFFORT}
    clients[2].close()
    onlooker.expect(2)
    clients[1].close()
    clients[0].close()
    onlooker.expect(0)


def test_others_are_answered_after_the_first_client_has_closed(
    side: Callable[[str], Side], onlooker: Onlooker
) -> None:
    calling, serving = side('calling'), side('serving')
    requests: Collector[Request] = Collector()
    serving.service('/add', requests)
    first, second = calling.client('/add'), calling.client('/add')
    for client in (first, second):
        calling.expect_server(client, '/add')
    unheard, heard = Answers(), Answers()
    unheard.ask(first)
    late, *_ = requests.expect(1)
    first.close()
    unheard.expect(0)
    third = calling.client('/add')
    calling.expect_server(third, '/add')
    heard.ask(third, b'of the third')
    late.reply(b'too late')  # it has the number of the third one's request
    requests.expect(2)[1].reply(b'for the third')
    assert [reply.payload for reply in heard.expect(1)] == [b'for the third']
    onlooker.expect(3)  # one too many, until all have closed
    second.close()
    third.close()
    onlooker.expect(0)


def test_a_service_that_is_made_later_is_reached_by_all_clients(side: Callable[[str], Side]) -> None:
    calling = side('calling')
    clients = [calling.client('/add') for _ in range(3)]
    serving = side('serving')
    serving.service('/add', lambda request: request.reply(b'yes'))
    for client in clients:
        calling.expect_server(client, '/add')
        answers = Answers()
        answers.ask(client)
        answers.expect(1)
    serving.session.close()
    calling.graph.wait_for(lambda: not any(client.reaches_server() for client in clients))
