"""Packets that another program of a host sends in a participant's name: they silence no topic."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import NamedTuple

import pytest
from helpers.rtps_network import Collector, Network, Publisher, Watcher

from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol import parameters as pids
from goalwire.rtps.protocol.identity import RANDOM_SIZE, make_prefix
from goalwire.rtps.protocol.messages import AckNack, Body, Data, Gap, Heartbeat, header
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.primitives import PARTICIPANT, SPDP_READER, SPDP_WRITER, NumberSet
from goalwire.rtps.protocol.qos import BEST_EFFORT, RELIABLE, Qos
from goalwire.rtps.protocol.reader import Reader
from goalwire.rtps.protocol.writer import Writer

KEEP_ALL = Qos(reliability=RELIABLE, depth=0)
FORGER = ('10.0.0.1', 40_000)
"""Another port of the host where the writer is."""
FAST_DDS = b'\x01\x0f'


class Scene(NamedTuple):
    network: Network
    writing: Participant
    writer: Writer
    publisher: Publisher
    reading: Participant
    watcher: Watcher
    reader: Reader
    collector: Collector

    def forge(self, *bodies: Body) -> None:
        """Send the reader's participant something in the name of the writer's."""
        for body in bodies:
            self.reading.receive(header(self.writing.prefix) + body.encode(), FORGER)

    def write(self, count: int) -> list[bytes]:
        """Write so many samples, and return them all."""
        written = [b'\0\1\0\0' + os.urandom(4) for _ in range(count)]
        for payload in written:
            self.writer.write(payload)
            self.network.run(0.005)
        self.network.run(2)
        return written


def _scene(prefix: bytes, qos: Qos = KEEP_ALL, loss: float = 0) -> Scene:
    network = Network(3)
    writing, _ = network.participant(same_host=True, settings={'prefix': prefix})
    reading, watcher = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = writing.create_writer('t', 'T', qos, publisher)
    reader = reading.create_reader('t', 'T', qos, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(0.5)
    network.loss = loss
    return Scene(network, writing, writer, publisher, reading, watcher, reader, collector)


@pytest.fixture(params=[0, 0.3], ids=['no loss', 'a third lost'])
def others(request: pytest.FixtureRequest) -> Scene:
    """A writer of another vendor, whose packets may come from any port."""
    return _scene(FAST_DDS + os.urandom(10), loss=request.param)


FAR = 2**40


def _heartbeat(ids: tuple[bytes, bytes], begun: int) -> list[Body]:
    return [Heartbeat(*ids, FAR, FAR, begun + 2**30)]


def _near_heartbeat(ids: tuple[bytes, bytes], begun: int) -> list[Body]:
    return [Heartbeat(*ids, begun + 3, begun + 2, begun + 2**30)]


def _gap(ids: tuple[bytes, bytes], begun: int) -> list[Body]:
    return [Gap(*ids, begun, NumberSet(FAR))]


def _gap_ahead(ids: tuple[bytes, bytes], begun: int) -> list[Body]:
    return [Gap(*ids, begun + 1, NumberSet(begun + 5000))]


def _all(ids: tuple[bytes, bytes], begun: int) -> list[Body]:
    return [body for forge in (_gap_ahead, _near_heartbeat, _heartbeat, _gap) for body in forge(ids, begun)]


@pytest.mark.parametrize('forge', [_heartbeat, _near_heartbeat, _gap, _gap_ahead, _all])
def test_a_reader_gets_all_whatever_was_told_of_what_will_not_come(
    others: Scene, forge: Callable[[tuple[bytes, bytes], int], list[Body]]
) -> None:
    ids = others.reader.entity_id, others.writer.entity_id
    written = others.write(3)
    others.forge(*forge(ids, 4))
    written += others.write(5)
    others.forge(*forge(ids, 9))
    others.writer.write(large := b'\0\1\0\0' + os.urandom(200_000))
    others.network.run(5)
    sent, came = [*written, large], others.collector.payloads
    if others.network.loss:  # what the network loses while a false HEARTBEAT holds is not asked for
        assert came == [payload for payload in sent if payload in came]
        assert len(came) > len(sent) / 2
    else:
        assert came == sent
    others.writer.write(b'\0\1\0\0last')
    assert others.network.run(5, lambda: others.collector.payloads[-1] == b'\0\1\0\0last')
    assert others.network.run(5, others.writer.is_acknowledged_by_all)


def test_a_first_heartbeat_may_be_false() -> None:
    network = Network()
    writing, _ = network.participant(same_host=True, settings={'prefix': FAST_DDS + os.urandom(10)})
    reading, _ = network.participant(same_host=True)
    collector = Collector()
    writer = writing.create_writer('t', 'T', KEEP_ALL, Publisher())
    reader = reading.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: collector.matched)
    false = Heartbeat(reader.entity_id, writer.entity_id, FAR, FAR, 2**30)
    reading.receive(header(writing.prefix) + false.encode(), FORGER)
    network.run(1)
    writer.write(b'\0\1\0\0late')
    network.run(1)
    writer.write(b'\0\1\0\0last')
    network.run(1)
    assert collector.payloads[-1] == b'\0\1\0\0last'


def test_a_false_sample_with_a_huge_number_silences_no_best_effort_topic() -> None:
    scene = _scene(FAST_DDS + os.urandom(10), Qos(reliability=BEST_EFFORT, depth=1))
    written = scene.write(3)
    scene.forge(Data(scene.reader.entity_id, scene.writer.entity_id, FAR, b'', b'\0\1\0\0lies'))
    assert scene.collector.payloads.pop() == b'\0\1\0\0lies'
    scene.collector.samples.pop()
    assert scene.collector.payloads == written
    assert scene.collector.payloads + scene.write(5) == scene.collector.payloads[:8]


def test_a_false_acknowledgement_stops_no_repairs() -> None:
    scene = _scene(FAST_DDS + os.urandom(10))
    ids = scene.reader.entity_id, scene.writer.entity_id
    false = AckNack(*ids, NumberSet(1), 2**30, is_final=True)
    scene.writing.receive(header(scene.reading.prefix) + false.encode(), ('10.0.0.2', 7410))
    scene.network.loss = 0.5
    written = scene.write(20)
    scene.network.run(10)
    assert scene.collector.payloads == written


def test_nobody_else_of_the_host_can_speak_for_a_participant_of_goalwire() -> None:
    scene = _scene(make_prefix(7410, os.urandom(RANDOM_SIZE)))
    ids = scene.reader.entity_id, scene.writer.entity_id
    guid = scene.writing.prefix + PARTICIPANT
    gone = pids.write_status(pids.DISPOSED | pids.UNREGISTERED, guid)
    scene.forge(
        Data(*ids, 1, b'', b'\0\1\0\0lies'),
        *_all(ids, 1),
        Data(SPDP_READER, SPDP_WRITER, 2, gone),
    )
    assert scene.watcher.refused == {'packet in the name of another program': 6}
    assert scene.collector.payloads + scene.write(3) == scene.collector.payloads
    assert len(scene.collector.samples) == 3
    assert scene.watcher.participants


def test_nobody_else_of_the_host_is_met_in_the_name_of_goalwire() -> None:
    network = Network()
    reading, watcher = network.participant(same_host=True)
    network.keeps, network.cut = True, lambda _from, _to: True
    other, _ = network.participant(same_host=True)
    announcement = next(packet for _, source, _, packet in network.packets if source[0] == '10.0.0.2')
    reading.receive(announcement, FORGER)
    assert not watcher.participants
    assert watcher.refused == {'packet in the name of another program': 1}
    reading.receive(announcement, ('10.0.0.2', 7410))
    assert list(watcher.participants) == [other.prefix]


# ---- samples that never become whole


def test_unfinished_samples_of_which_nothing_more_comes_are_let_go() -> None:
    scene = _scene(make_prefix(7410, os.urandom(RANDOM_SIZE)), Qos(reliability=BEST_EFFORT, depth=1))
    fragments = 0

    def is_cut(_from: str, _to: str) -> bool:
        nonlocal fragments
        fragments += 1
        return fragments > 2

    scene.network.cut = is_cut
    scene.writer.write(b'\0\1\0\0' + bytes(300_000))
    scene.network.run(1)
    scene.network.cut = lambda _from, _to: False
    assert scene.reading.kept > 0
    scene.network.run(bounds.UNFINISHED_S + 1)
    assert scene.reading.kept == 0
    assert scene.watcher.refused == {'unfinished sample': 1}


def test_a_reliable_sample_that_was_let_go_comes_when_its_writer_is_back() -> None:
    scene = _scene(make_prefix(7410, os.urandom(RANDOM_SIZE)))
    scene.writer.write(payload := b'\0\1\0\0' + os.urandom(600_000))
    assert scene.network.run(0.1, lambda: scene.reading.kept)
    scene.network.cut = lambda _from, _to: True
    scene.network.run(bounds.UNFINISHED_S + 2)
    assert scene.reading.kept == 0
    scene.network.cut = lambda _from, _to: False
    scene.network.run(5)
    assert scene.collector.payloads == [payload]
