"""Sessions on real sockets."""

from __future__ import annotations

import os
import socket
import struct
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from threading import Event
from time import monotonic

import pytest
from helpers.isolation import fresh_domain
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.rtps_network import Collector, Watcher
from helpers.rtps_sides import RELIABLE_QOS, Side

from goalwire.errors import ForkedError, TransportError
from goalwire.host_addresses import addresses
from goalwire.rtps.io import sockets
from goalwire.rtps.io.addresses import (
    GROUP,
    Ports,
    Reach,
    choose_announced_addresses,
    data_port,
    discovery_port,
    first_port,
)
from goalwire.rtps.io.session import RtpsSession, Settings
from goalwire.rtps.protocol.announcements import EndpointData
from goalwire.rtps.protocol.primitives import Address
from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL, Qos
from goalwire.rtps.protocol.reader import ReaderListener, Sample
from goalwire.rtps.protocol.writer import MOST_UNACKNOWLEDGED, Writer, WriterListener

PROGRAMS = Path(__file__).parent / 'programs'
KEEP_ALL = Qos(reliability=RELIABLE, depth=0, max_blocking=10**8)


@pytest.fixture
def domain() -> int:
    """A domain of this test's own."""
    return fresh_domain()


@pytest.fixture
def pair(domain: int) -> Iterator[tuple[Side, Side]]:
    """Two sessions that are about to find each other."""
    with Side(domain) as one, Side(domain) as other:
        yield one, other


def _send(here: Side, there: Side, sent: list[bytes]) -> list[bytes | None]:
    """Send samples one after the other, by a topic of their own, and return what came."""
    topic = f'topic {monotonic()}'
    writer, publisher = here.writer(topic)
    _, collector = there.reader(topic)
    here.wait_for(lambda: publisher.matched, 'a match')
    there.wait_for(lambda: collector.matched, 'a match')
    for at, payload in enumerate(sent, 1):
        assert here.session.write(writer, payload)
        there.wait_for(partial(_has, collector, at), 'a sample')
    return collector.payloads


def _has(collector: Collector, count: int) -> bool:
    return len(collector.samples) >= count


@pytest.mark.parametrize('size', [0, 1000, 100_000, 1_000_000])
def test_samples_of_all_sizes_go_both_ways(pair: tuple[Side, Side], size: int) -> None:
    sent = [b'\0\1\0\0' + bytes([number]) * (size + 4 & ~3) for number in range(5)]
    for here, there in (pair, pair[::-1]):
        assert _send(here, there, sent) == sent
        assert _send(here, here, sent) == sent


@pytest.mark.parametrize('way', ['reads', 'idle'])
def test_another_process_answers(domain: int, way: str) -> None:
    with Program(PROGRAMS / 'echo.py', str(domain), way) as echo, Side(domain) as side:
        echo.expect('ready')
        writer, publisher = side.writer('ping', type_name='T')
        _, collector = side.reader('pong', type_name='T')
        # A match tells what this side knows; only `answered` tells that the other's writer knows the reader.
        side.wait_for(lambda: publisher.matched and collector.answered, 'a match')
        for number in range(100):
            payload = b'\0\1\0\0' + number.to_bytes(4, 'little')
            writer.write(payload)
            side.wait_for(partial(_has, collector, number + 1), 'an answer')
        assert collector.payloads[-1] == payload
        echo.kill()
        side.wait_for(lambda: not (publisher.matched or collector.matched), 'the end of its lease')
        assert not side.watcher.participants


class _HeldUp(Watcher):
    """Holds up the thread that reads, from the news of a topic's writer until `goes_on` is set."""

    def __init__(self, topic: str) -> None:
        super().__init__()
        self.has_stopped, self.goes_on = Event(), Event()
        self._topic = topic

    def on_endpoint(self, endpoint: EndpointData) -> None:
        super().on_endpoint(endpoint)
        if endpoint.topic == self._topic:
            self.has_stopped.set()
            assert self.goes_on.wait(PATIENCE)


class _Echo(ReaderListener):
    """Answers each sample by a writer."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer

    def on_sample(self, sample: Sample) -> None:
        self._writer.write(bytes(sample.payload or b''))


def test_news_of_a_reader_is_read_before_samples_that_came_after_it(domain: int) -> None:
    held_up = _HeldUp('ping')
    with Side(domain) as side, closing(RtpsSession(Settings(domain=domain), held_up)) as slow:
        echo = _Echo(slow.participant.create_writer('pong', 'T', RELIABLE_QOS, WriterListener()))
        slow.participant.create_reader('ping', 'T', RELIABLE_QOS, echo)
        side.wait_for(lambda: len(side.watcher.endpoints) == 2, "the other's writer and reader")
        writer, _ = side.writer('ping', type_name='T')
        try:
            side.wait_for(held_up.has_stopped.is_set, 'the news of the writer')
            _, collector = side.reader('pong', type_name='T')
            writer.write(b'\0\1\0\0ping')
        finally:
            held_up.goes_on.set()
        side.wait_for(lambda: collector.payloads == [b'\0\1\0\0ping'], 'the answer')


def test_late_joiners_get_the_history(domain: int) -> None:
    latched = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL, depth=3)
    with Side(domain) as one:
        writer, _ = one.writer('t', latched)
        for number in range(5):
            writer.write(b'\0\1\0\0' + bytes([number]) * 4)
        with Side(domain) as other:
            _, collector = other.reader('t', latched)
            other.wait_for(lambda: len(collector.samples) == 3, 'the history')
            assert [sample.number for sample in collector.samples] == [3, 4, 5]
        one.wait_for(lambda: not one.watcher.participants, 'the end of the other')


def test_what_has_come_in_large_packets_stays_when_more_comes(pair: tuple[Side, Side]) -> None:
    sent = [bytes([number]) * size for number, size in enumerate(3 * (30_000, 200_000, 5_000, 1_000_000))]
    assert _send(*pair, sent) == sent
    assert _send(*pair, sent[::-1]) == sent[::-1]


def test_a_full_writer_waits_for_its_readers(pair: tuple[Side, Side]) -> None:
    one, other = pair
    writer, publisher = one.writer('t', KEEP_ALL)
    reader, collector = other.reader('t', KEEP_ALL)
    one.wait_for(lambda: publisher.matched and any(each.has_answered for each in writer.readers.values()))
    reader.pause()
    for _ in range(MOST_UNACKNOWLEDGED):
        assert one.session.write(writer, b'\0\1\0\0full')
    begun = monotonic()
    assert one.session.write(writer, b'\0\1\0\0full') is None
    assert monotonic() - begun >= 0.1
    reader.resume()
    assert one.session.write(writer, b'\0\1\0\0room')
    other.wait_for(lambda: len(collector.samples) == MOST_UNACKNOWLEDGED + 1, 'all')
    assert one.session.wait_until_acknowledged(10)


def test_announcements_go_to_the_group_if_the_subnet_is_looked_at(domain: int) -> None:
    if not addresses():
        pytest.skip('this machine has no interface but loopback')
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as group:
        group.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, 'SO_REUSEPORT'):
            group.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        group.bind((GROUP, first_port(domain)))
        for host in addresses():
            joined = struct.pack('4s4s', socket.inet_aton(GROUP), socket.inet_aton(host))
            group.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, joined)
        group.settimeout(10)
        with Side(domain, Reach.SUBNET) as one, Side(domain, Reach.SUBNET) as other:
            packet, _ = group.recvfrom(65536)
            assert packet[:4] == b'RTPS'
            assert packet[8:20] in {one.participant.prefix, other.participant.prefix}
            one.wait_for(lambda: one.watcher.participants, 'the other')
            other.wait_for(lambda: other.watcher.participants, 'the one')


def test_who_looks_nowhere_opens_nothing(domain: int) -> None:
    with Side(domain, Reach.OFF) as side:
        assert side.participant.data.metatraffic == ()
        writer, _ = side.writer('t')
        _, collector = side.reader('t')
        writer.write(b'\0\1\0\0here')
        assert collector.payloads == [b'\0\1\0\0here']


def test_ports_are_counted_up_and_may_run_out(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sockets, 'MOST_PARTICIPANTS', 2)
    with Side(domain) as one, Side(domain) as other:
        for nth, side in enumerate((one, other)):
            assert side.participant.data.metatraffic[0][1] == discovery_port(domain, nth)
            assert side.participant.data.default[0][1] == data_port(domain, nth)
        with pytest.raises(TransportError, match=f'domain {domain} has 2 participants'):
            Side(domain)


def test_domains_have_ports_up_to_the_last() -> None:
    assert (first_port(0), discovery_port(1, 0), data_port(1, 2)) == (7400, 7660, 7665)
    with pytest.raises(TransportError, match='no domain 233'):
        first_port(233)


def test_peers_are_announced_to() -> None:
    found = choose_announced_addresses(0, ('127.0.0.1', '192.0.2.2'), ('192.0.2.7', '192.0.2.8:7999'))
    assert ('127.0.0.1', 7410) in found
    assert ('192.0.2.7', 7472) in found
    assert ('192.0.2.2', 7410) in found
    assert ('192.0.2.8', 7999) in found
    assert len(found) == 97
    assert choose_announced_addresses(0, (), ('[fd00::7]:7400', 'fd00::8'))[:2] == (
        ('fd00::7', 7400),
        ('fd00::8', 7410),
    )
    with pytest.raises(TransportError, match=r"peer 'nowhere\.invalid' is not known"):
        choose_announced_addresses(0, (), ('nowhere.invalid',))


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system does not fork')
@pytest.mark.filterwarnings('ignore:This process:DeprecationWarning')
def test_a_forked_child_lets_go_of_the_sockets(domain: int) -> None:
    with Side(domain) as side:
        writer, _ = side.writer('t')
        child = os.fork()
        if not child:  # pragma: no cover - in the child
            code = 1
            try:
                side.session.write(writer, b'\0\1\0\0')
            except ForkedError:
                try:
                    with Side(domain):
                        code = 0
                except Exception:
                    code = 2
            os._exit(code)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert writer.write(b'\0\1\0\0'), 'the parent goes on'


@pytest.mark.skipif(not socket.has_ipv6, reason='this Python has no IPv6')
def test_ipv6_in_place_of_ipv4(domain: int) -> None:
    try:
        one = Side(domain, ipv6=True)
    except TransportError:
        pytest.skip('this machine has no IPv6')
    with one, Side(domain, ipv6=True) as other, Side(domain) as on_ipv4:
        assert _send(one, other, [b'\0\1\0\0six!', bytes(200_000)])
        assert ':' in one.participant.data.default[0][0]
        assert other.participant.prefix in one.watcher.participants
        assert on_ipv4.participant.prefix not in one.watcher.participants


def test_an_index_that_is_asked_for_has_its_ports_or_none(domain: int) -> None:
    with Side(domain, participant=7) as side:
        assert side.participant.data.metatraffic[0][1] == discovery_port(domain, 7)
        with pytest.raises(TransportError, match='the ports of participant 7'):
            Side(domain, participant=7)


def test_ports_may_be_counted_otherwise_if_all_do(domain: int) -> None:
    ports = Ports(base=9000, domain_gain=200, participant_gain=4, discovery=20, data=22)
    with Side(domain, ports=ports) as one, Side(domain, ports=ports) as other:
        assert one.participant.data.metatraffic[0][1] == 9000 + 200 * domain + 20
        assert _send(one, other, [b'\0\1\0\0here']) == [b'\0\1\0\0here']


def test_packets_are_as_large_as_is_asked_for(domain: int) -> None:
    with Side(domain, packet_size=1472) as one, Side(domain) as other:
        sizes: list[int] = []
        send = one.participant.send_packet

        def measure(packet: bytes, to: Address) -> None:
            sizes.append(len(packet))
            send(packet, to)

        one.participant.send_packet = measure
        one.participant.send_packet_parts = None  # so parts come joined, too
        assert _send(one, other, [bytes(20_000)]) == [bytes(20_000)]
        assert 1000 < max(sizes) <= 1472
