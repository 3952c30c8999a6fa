"""The bounds of what others can take from a participant, and the addresses that are sent nothing."""

from __future__ import annotations

import os
from typing import NamedTuple

import pytest
from helpers.rtps_network import Collector, Network, Publisher, Watcher

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.announcements import (
    EndpointData,
    ParticipantData,
    write_endpoint,
    write_participant,
)
from goalwire.rtps.protocol.messages import Data, DataFrag, Heartbeat, header, info_dst
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.primitives import (
    PUBLICATIONS_READER,
    PUBLICATIONS_WRITER,
    SPDP_READER,
    SPDP_WRITER,
    SUBSCRIPTIONS_READER,
    SUBSCRIPTIONS_WRITER,
    Address,
)
from goalwire.rtps.protocol.qos import BEST_EFFORT, RELIABLE, Qos
from goalwire.rtps.protocol.reader import Reader

STRANGER = ('203.0.113.9', 7410)
VICTIM = ('198.51.100.7', 7410)
RELIABLE_QOS = Qos(reliability=RELIABLE, depth=10)


class Stranger:
    """Speaks to one participant as another one, from an address of its own."""

    def __init__(self, to: Participant, at: Address = STRANGER) -> None:
        self.prefix = os.urandom(12)
        self._to, self._at = to, at
        self._told = 0

    def announce(self, *addresses: Address, at: Address | None = None, names_it: bool = False) -> int:
        """Tell these addresses, and return how many bytes that was."""
        told = write_participant(
            ParticipantData(
                self.prefix, metatraffic=addresses or (self._at,), default=addresses or (self._at,)
            )
        )
        data = Data(SPDP_READER, SPDP_WRITER, 1, b'', told).encode()
        named = info_dst(self._to.prefix) if names_it else b''
        return self.send(named + data, at)

    def send(self, submessages: bytes, at: Address | None = None) -> int:
        """Send a packet, and return its size."""
        packet = header(self.prefix) + submessages
        self._to.receive(packet, at or self._at)
        return len(packet)

    def prove(self, at: Address | None = None) -> None:
        """Name the participant, as one can that reads what it is sent."""
        beat = Heartbeat(PUBLICATIONS_READER, PUBLICATIONS_WRITER, 1, 0, 1).encode()
        self.send(info_dst(self._to.prefix) + beat, at)

    def tell(self, endpoint: EndpointData, *, is_writer: bool) -> None:
        """Tell of an endpoint."""
        self._told += 1
        ids = (
            (PUBLICATIONS_READER, PUBLICATIONS_WRITER)
            if is_writer
            else (SUBSCRIPTIONS_READER, SUBSCRIPTIONS_WRITER)
        )
        beat = Heartbeat(*ids, 1, self._told, self._told + 1).encode()
        data = Data(*ids, self._told, b'', write_endpoint(endpoint)).encode()
        self.send(info_dst(self._to.prefix) + beat + data + beat)

    def endpoint(self, number: int, kind: int, topic: str = 't', *addresses: Address) -> EndpointData:
        """Return a writer or a reader, by the last byte of its entity id."""
        guid = self.prefix + number.to_bytes(3, 'big') + bytes((kind,))
        return EndpointData(guid, topic, 'T', RELIABLE_QOS, addresses=addresses)


class Scene(NamedTuple):
    network: Network
    one: Participant
    watcher: Watcher
    publisher: Publisher
    collector: Collector
    reader: Reader

    def sent_to(self, address: Address) -> int:
        """Return how many bytes were sent to a host."""
        return sum(len(packet) for _, _, to, packet in self.network.packets if to[0] == address[0])


@pytest.fixture
def scene() -> Scene:
    """A participant with a writer and a reader of topic t, whose packets are kept."""
    network = Network()
    one, watcher = network.participant(settings={'peers': ()})
    publisher, collector = Publisher(), Collector()
    one.create_writer('t', 'T', RELIABLE_QOS, publisher)
    reader = one.create_reader('t', 'T', RELIABLE_QOS, collector)
    network.keeps = True
    return Scene(network, one, watcher, publisher, collector, reader)


# ---- nobody is sent what he has not asked for


def test_a_participant_that_tells_a_foreign_address_gets_an_answer_there_and_no_more(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    size = stranger.announce(VICTIM)
    stranger.prove()
    for number in range(20):
        stranger.announce(VICTIM, names_it=True)
        stranger.tell(stranger.endpoint(number, 4), is_writer=False)
    scene.network.run(10)
    assert scene.sent_to(VICTIM) <= size
    assert not [one for one in scene.publisher.matched if one.startswith(stranger.prefix)]
    assert scene.watcher.refused['participant that tells no address on its host']


def test_who_has_proven_to_be_somewhere_is_not_followed_to_another_host(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    stranger.announce(VICTIM)
    scene.network.run(3)
    assert scene.sent_to(VICTIM) == 0
    assert scene.watcher.refused['announcement of another host'] == 1


def test_an_endpoint_at_a_foreign_address_gets_nothing(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    stranger.tell(stranger.endpoint(1, 4, 't', VICTIM), is_writer=False)
    stranger.tell(stranger.endpoint(2, 4), is_writer=False)
    scene.network.run(1)
    assert scene.sent_to(VICTIM) == 0
    assert [guid for guid in scene.publisher.matched if guid.startswith(stranger.prefix)] == [
        stranger.endpoint(2, 4).guid
    ]
    assert scene.watcher.refused['endpoint at an address of another host'] == 1


def test_who_adds_an_address_stays_where_it_was(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    stranger.tell(stranger.endpoint(1, 4), is_writer=False)
    before = list(scene.publisher.matched)
    stranger.announce(VICTIM, STRANGER)
    stranger.prove(at=VICTIM)
    scene.network.run(3)
    assert scene.publisher.matched == before
    assert scene.sent_to(VICTIM) == 0


def test_a_participant_is_followed_to_another_port_of_its_host(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    stranger.tell(stranger.endpoint(1, 4), is_writer=False)
    stranger.announce((STRANGER[0], 9999))
    scene.network.packets.clear()
    scene.network.run(3)
    assert {to for _, _, to, _ in scene.network.packets} == {(STRANGER[0], 9999)}


def test_a_sample_before_the_first_heartbeat_has_it_asked_for_at_once(scene: Scene) -> None:
    """RustDDS tells nothing before it has written, and by then it is asked but once a second."""
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    writer = stranger.endpoint(1, 3)
    stranger.tell(writer, is_writer=True)
    scene.network.run(5)
    asked = scene.sent_to(STRANGER)
    stranger.send(Data(scene.reader.entity_id, writer.entity_id, 1, b'', b'\0\1\0\0told').encode())
    assert scene.sent_to(STRANGER) > asked
    stranger.send(Heartbeat(scene.reader.entity_id, writer.entity_id, 1, 1, 1).encode())
    assert scene.collector.payloads == [b'\0\1\0\0told']


# ---- bounds


def test_endpoints_of_all_participants_together_have_a_bound(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'ENDPOINTS_SIZE', 5000)
    for _ in range(4):
        stranger = Stranger(scene.one)
        stranger.announce()
        stranger.prove()
        for number in range(10):
            stranger.tell(stranger.endpoint(number, 3, f'topic{number}'), is_writer=True)
    assert 5 < len(scene.watcher.endpoints) < 40
    assert len(scene.watcher.endpoints) + scene.watcher.refused['endpoint'] == 40
    scene.network.run(200)
    assert not scene.watcher.endpoints, 'their leases are over'
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    stranger.tell(stranger.endpoint(1, 3), is_writer=True)
    assert len(scene.watcher.endpoints) == 1, 'there is room again'


def test_endpoints_of_one_participant_have_a_bound(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'MOST_ENDPOINTS', 3)
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    for number in range(5):
        stranger.tell(stranger.endpoint(number, 3), is_writer=True)
    assert len(scene.watcher.endpoints) == 3
    assert scene.watcher.refused['endpoint'] == 2


def test_locators_of_one_announcement_have_a_bound(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    stranger.announce(*((f'203.0.113.{number}', 7410) for number in range(1, 60)))
    (found,) = scene.watcher.participants.values()
    assert len(found.metatraffic) == len(found.default) == bounds.MOST_LOCATORS
    assert scene.watcher.refused['locator'] == 1


def test_a_sample_costs_a_bounded_number_of_packets_for_one_participant(scene: Scene) -> None:
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    for number in range(1, 200):
        stranger.tell(stranger.endpoint(number, 4, 't', (STRANGER[0], 8000 + number)), is_writer=False)
    assert len([guid for guid in scene.publisher.matched if guid.startswith(stranger.prefix)]) == (
        bounds.MOST_ADDRESSES
    )
    assert scene.watcher.refused['address'] == 199 - bounds.MOST_ADDRESSES


def test_packets_of_unknown_writers_have_a_bound(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'EARLY_SIZE', 100_000)
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    for number in range(1, 100):
        writer = stranger.endpoint(number, 3).entity_id
        stranger.send(Data(b'\0\0\0\0', writer, 1, b'', bytes(10_000)).encode())
    assert scene.watcher.refused['packet of an unknown writer'] == 90
    scene.network.run(bounds.EARLY_S + 0.1)
    stranger.send(Data(b'\0\0\0\0', writer, 1, b'', bytes(10_000)).encode())
    assert scene.watcher.refused['packet of an unknown writer'] == 90, 'the others were let go of'


@pytest.fixture
def writers(scene: Scene) -> list[tuple[Stranger, EndpointData]]:
    """Ten writers of topic t, of ten strangers."""
    made = []
    for _ in range(10):
        stranger = Stranger(scene.one)
        stranger.announce()
        stranger.prove()
        writer = stranger.endpoint(1, 3)
        stranger.tell(writer, is_writer=True)
        stranger.send(Heartbeat(scene.reader.entity_id, writer.entity_id, 1, 0, 1).encode())
        made.append((stranger, writer))
    return made


def test_samples_that_come_too_early_have_bounds(
    scene: Scene, writers: list[tuple[Stranger, EndpointData]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'AHEAD_SIZE', 50_000)
    monkeypatch.setattr(bounds, 'KEPT_SIZE', 200_000)
    for stranger, writer in writers:
        for number in range(2, 12):
            stranger.send(Data(scene.reader.entity_id, writer.entity_id, number, b'', bytes(10_000)).encode())
    assert scene.one.kept == 200_000
    assert scene.watcher.refused['sample too far ahead'] == 4 * 5
    assert scene.watcher.refused['sample that waits for others'] == 6 * 10
    (stranger, writer), *_ = writers
    stranger.send(Data(scene.reader.entity_id, writer.entity_id, 1, b'', b'\0\1\0\0').encode())
    assert len(scene.collector.samples) == 6, 'the first writer goes on'
    assert scene.one.kept == 150_000
    scene.network.run(200)
    assert scene.one.kept == 0, 'their leases are over'


def test_unfinished_samples_have_bounds(
    scene: Scene, writers: list[tuple[Stranger, EndpointData]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounds, 'KEPT_SIZE', 100_000)
    for stranger, writer in writers:
        for number in range(1, 12):
            fragment = DataFrag(
                scene.reader.entity_id, writer.entity_id, number, 1, 1, 5000, 15_000, b'', bytes(5000)
            )
            stranger.send(fragment.encode())
            assert scene.one.kept <= 100_000
    assert scene.watcher.refused['sample that waits for others']
    scene.network.run(200)
    assert scene.one.kept == 0, 'their leases are over'


def test_best_effort_readers_keep_no_samples_that_were_overtaken(scene: Scene) -> None:
    collector = Collector()
    reader = scene.one.create_reader('b', 'T', Qos(reliability=BEST_EFFORT), collector)
    stranger = Stranger(scene.one)
    stranger.announce()
    stranger.prove()
    writer = stranger.endpoint(1, 3, 'b')
    stranger.tell(writer, is_writer=True)
    for number in range(1, 200):
        part = DataFrag(reader.entity_id, writer.entity_id, number, 1, 1, 1000, 3000, b'', bytes(1000))
        stranger.send(part.encode())
    assert 0 < scene.one.kept <= 1000 * bounds.MOST_UNFINISHED
    stranger.send(Data(reader.entity_id, writer.entity_id, 200, b'', b'\0\1\0\0').encode())
    assert collector.payloads == [b'\0\1\0\0']
    assert scene.one.kept == 0
