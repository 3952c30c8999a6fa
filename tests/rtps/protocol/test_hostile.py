"""Mutated packets against participants that work: none raises, none hangs, and topics go on."""

from __future__ import annotations

from random import Random

import pytest
from helpers.rtps_captured import packets
from helpers.rtps_network import Collector, Network, Publisher

from goalwire.rtps.protocol import bounds, wire
from goalwire.rtps.protocol.messages import (
    AckNack,
    Body,
    Data,
    DataFrag,
    Gap,
    Heartbeat,
    HeartbeatFrag,
    NackFrag,
    header,
)
from goalwire.rtps.protocol.primitives import NumberSet
from goalwire.rtps.protocol.qos import RELIABLE, Qos

QOS = Qos(reliability=RELIABLE, depth=10)
INTERESTING = (0, 1, 2, 3, 4, 7, 8, 0x7F, 0x80, 0xFE, 0xFF)


@pytest.fixture(autouse=True)
def listeners_that_raise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Listeners are called outside the lock; one that raises fails the test, too."""

    def fail(where: str, error: Exception) -> None:
        raise error

    monkeypatch.setattr(wire, 'report_failure', fail)


def _mutate(random: Random, packet: bytes) -> bytes:
    data = bytearray(packet)
    for _ in range(random.randint(1, 6)):
        data[random.randrange(8, len(data))] = random.choice(INTERESTING)
    return bytes(data[: random.randint(20, len(data))] if random.random() < 0.2 else data)


def _hammer(count: int, seed: int) -> None:
    """Send mutated packets of real peers, and of the two participants themselves, to one of them."""
    random = Random(seed)
    network = Network(seed)
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    network.keeps = True
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', QOS, publisher)
    other.create_reader('t', 'T', QOS, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    writer.write(bytes(200_000))
    network.run(0.1)
    own = [
        packet for _, source, _, packet in network.packets if source[0] == '10.0.0.1' and len(packet) < 2000
    ]
    network.keeps = False
    captured = [packet.data for packet in packets()]
    for number in range(count):
        if random.random() < 0.5:
            source, packet = ('10.0.0.1', 7410), random.choice(own)
        else:
            source, packet = ('10.0.0.3', 7410), random.choice(captured)
        other.receive(_mutate(random, packet), source)
        if number % 100 == 0:
            network.run(0.01)
    network.run(30)
    third, _ = network.participant(same_host=True)
    last = Collector()
    third.create_reader('t', 'T', QOS, last)
    assert network.run(5, lambda: len(publisher.matched) >= 2 and last.matched)
    writer.write(b'\0\1\0\0last')
    assert network.run(5, lambda: last.payloads == [b'\0\1\0\0last'])


@pytest.mark.parametrize('seed', range(3))
def test_mutated_packets_do_no_harm(seed: int) -> None:
    _hammer(2000, seed)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(3600)
def test_a_million_mutated_packets_do_no_harm() -> None:
    for seed in range(100, 120):
        _hammer(50_000, seed)


def test_numbers_without_measure_cost_nothing() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', QOS, publisher)
    reader = other.create_reader('t', 'T', QOS, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    writer.write(b'\0\1\0\0here')
    network.run(0.1)
    ids = reader.entity_id, writer.entity_id
    huge = 2**62
    to_reader: list[Body] = [
        Data(*ids, huge, b'', b'\0\1\0\0'),
        DataFrag(*ids, huge, 1, 1, 1000, 2**30, b'', bytes(1000)),
        DataFrag(*ids, 3, 1, 1, 1000, 2**32 - 1, b'', bytes(1000)),
        DataFrag(*ids, 4, 1, 1, 0, 1000, b'', bytes(1000)),
        DataFrag(*ids, 5, 1, 65535, 1, 1000, b'', bytes(1000)),
        HeartbeatFrag(*ids, 3, 2**32 - 1, 7),
        Gap(*ids, 5, NumberSet(huge)),
        Heartbeat(*ids, 1, huge, 1000),
    ]
    to_writer: list[Body] = [
        AckNack(*ids, NumberSet(huge), 1000),
        AckNack(*ids, NumberSet(huge, 256, (0xFFFFFFFF,) * 8), 1001),
        NackFrag(*ids, huge, NumberSet(2**32 - 1, 256, (0xFFFFFFFF,) * 8), 1000),
    ]
    for body in to_reader:
        other.receive(header(one.prefix) + body.encode(), ('10.0.0.1', 7410))
    for body in to_writer:
        one.receive(header(other.prefix) + body.encode(), ('10.0.0.2', 7410))
    (proxy,) = reader.writers.values()
    assert len(proxy.backlog.held) <= bounds.AHEAD
    network.keeps = True
    network.run(1)
    assert len(network.packets) < 100


def test_a_false_heartbeat_starts_no_endless_exchange() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', QOS, publisher)
    reader = other.create_reader('t', 'T', QOS, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(0.1)
    false = Heartbeat(reader.entity_id, writer.entity_id, 1, 2**40, 1_000_000)
    other.receive(header(one.prefix) + false.encode(), ('10.0.0.1', 7410))
    network.keeps = True
    for number in range(5):
        writer.write(b'\0\1\0\0' + bytes([number]) * 4)
        network.run(0.2)
    assert len(collector.samples) == 5
    assert len(network.packets) < 200


def test_fragments_of_samples_that_never_end_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'KEPT_SIZE', 100_000)
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    collector = Collector()
    writer = one.create_writer('t', 'T', QOS, Publisher())
    reader = other.create_reader('t', 'T', QOS, collector)
    assert network.run(1, lambda: collector.matched and writer.readers)
    network.run(0.1)
    for number in range(1, 2000):
        body = DataFrag(reader.entity_id, writer.entity_id, number, 1, 1, 2000, 4000, b'', bytes(2000))
        other.receive(header(one.prefix) + body.encode(), ('10.0.0.1', 7410))
    (proxy,) = reader.writers.values()
    assert len(proxy.backlog.partials) <= bounds.MOST_UNFINISHED
    assert sum(one.kept for one in proxy.backlog.partials.values()) <= 102_000
