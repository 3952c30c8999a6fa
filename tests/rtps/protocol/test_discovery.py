"""Participants that come and go, their endpoints, and strangers."""

from __future__ import annotations

import os

from helpers.rtps_network import Collector, Network, Publisher

from goalwire.records import replace
from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.announcements import (
    EndpointData,
    ParticipantData,
    write_endpoint,
    write_participant,
)
from goalwire.rtps.protocol.messages import Data, Heartbeat, header, info_dst
from goalwire.rtps.protocol.primitives import (
    PUBLICATIONS_READER,
    PUBLICATIONS_WRITER,
    SPDP_READER,
    SPDP_WRITER,
)
from goalwire.rtps.protocol.qos import MANUAL_BY_TOPIC, RELIABLE, TRANSIENT_LOCAL, Qos

RELIABLE_QOS = Qos(reliability=RELIABLE, depth=10)
STRANGER = '10.0.9.9', 7410


def _announcement(prefix: bytes, host: str = STRANGER[0], **told: object) -> bytes:
    address = host, 7410
    data = ParticipantData(prefix, metatraffic=(address,), default=(address,), **told)  # type: ignore[arg-type]
    return header(prefix) + Data(SPDP_READER, SPDP_WRITER, 1, b'', write_participant(data)).encode()


def test_participants_know_each_other_and_their_endpoints() -> None:
    network = Network()
    one, watcher = network.participant(settings={'user_data': b'enclave=/;'})
    other, others_watcher = network.participant()
    assert network.run(1, lambda: watcher.participants and others_watcher.participants)
    assert others_watcher.participants[one.prefix].user_data == b'enclave=/;'
    writer = one.create_writer('t', 'T', RELIABLE_QOS, Publisher(), b'typehash=1;')
    reader = other.create_reader('u', 'U', RELIABLE_QOS, Collector())
    assert network.run(1, lambda: watcher.endpoints and others_watcher.endpoints)
    assert others_watcher.endpoints == {writer.data.guid: writer.data}
    assert watcher.endpoints == {reader.data.guid: reader.data}
    one.delete(writer)
    other.delete(reader)
    assert network.run(1, lambda: not (watcher.endpoints or others_watcher.endpoints))


def test_two_that_meet_tell_each_other_everything_once() -> None:
    network = Network()
    network.keeps = True
    one, _ = network.participant(same_host=True)
    writers = [one.create_writer(f't{number}', 'T', RELIABLE_QOS, Publisher()) for number in range(20)]
    other, watcher = network.participant(same_host=True)
    assert network.run(0.05, lambda: len(watcher.endpoints) == len(writers))
    network.run(0.05)
    tells = [packet for _, _, to, packet in network.packets if to[0] == '10.0.0.2' and b't19' in packet]
    assert len(tells) == 1
    of_one = [
        packet for _, source, to, packet in network.packets if (source[0], to[0]) == ('10.0.0.1', '10.0.0.2')
    ]
    answers = [packet for packet in of_one if SPDP_WRITER in packet and other.prefix in packet]
    assert len(answers) == 1


def test_what_was_lost_when_two_met_is_told_again() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    one.create_writer('t', 'T', RELIABLE_QOS, Publisher())
    _, watcher = network.participant(same_host=True)
    network.cut = lambda source, _: source == '10.0.0.1' and 0 < network.now < 0.004
    assert network.run(1, lambda: watcher.participants)
    met = network.now
    assert network.run(1, lambda: watcher.endpoints)
    assert network.now - met < 0.05


def test_who_closes_is_gone_at_once() -> None:
    network = Network()
    one, watcher = network.participant()
    other, _ = network.participant()
    publisher = Publisher()
    one.create_writer('t', 'T', RELIABLE_QOS, publisher)
    other.create_reader('t', 'T', RELIABLE_QOS, Collector())
    assert network.run(1, lambda: publisher.matched and watcher.endpoints)
    other.close()
    assert network.run(0.01, lambda: not watcher.participants)
    assert not watcher.endpoints
    assert not publisher.matched


def test_who_has_closed_takes_nothing_more() -> None:
    network = Network()
    one, watcher = network.participant(same_host=True)
    one.close()
    one.receive(_announcement(os.urandom(12), host='10.0.0.2'), ('10.0.0.2', 7410))
    assert not watcher.participants


def test_who_falls_silent_is_gone_after_its_lease() -> None:
    network = Network()
    _, watcher = network.participant()
    network.participant(settings={'lease': 10 * 10**9})
    assert network.run(1, lambda: watcher.participants)
    network.run(60)
    assert watcher.participants, 'announcements renew the lease'
    network.cut = lambda *_: True
    network.run(6)
    assert watcher.participants
    network.run(5)
    assert not watcher.participants
    network.cut = lambda *_: False
    assert network.run(5, lambda: watcher.participants), 'and it is found again'


def test_other_domains_and_tags_are_not_seen() -> None:
    network = Network()
    _, watcher = network.participant()
    network.participant(settings={'domain': 1})
    network.participant(settings={'tag': 'off'})
    network.run(10)
    assert not watcher.participants


def test_endpoints_that_do_not_fit_are_told_of() -> None:
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    publisher, collector = Publisher(), Collector()
    one.create_writer('t', 'T', Qos(), publisher)
    other.create_reader('t', 'T', RELIABLE_QOS, collector)
    other.create_reader('t', 'Another', Qos(), Collector())
    other.create_reader('t', 'T', Qos(partition=('elsewhere',)), Collector())
    assert network.run(1, lambda: publisher.incompatible and collector.incompatible)
    network.run(1)
    assert publisher.incompatible == collector.incompatible == ['reliability']
    assert not publisher.matched


def test_a_stranger_gets_no_more_than_it_has_sent() -> None:
    network = Network()
    one, watcher = network.participant(settings={'peers': ()})
    for number in range(50):
        one.create_writer(f'topic{number}', 'T', RELIABLE_QOS, Publisher())
    network.keeps = True
    small = _announcement(os.urandom(12))
    for packet in (small, _announcement(os.urandom(12), user_data=bytes(b'x' * 400))):
        network.packets.clear()
        one.receive(packet, STRANGER)
        network.run(5)
        assert sum(len(sent) for *_, sent in network.packets) <= len(packet)
    assert len(watcher.participants) == 2


def test_a_stranger_that_reads_what_it_is_sent_is_told_everything() -> None:
    network = Network()
    one, _ = network.participant(settings={'peers': ()})
    writer = one.create_writer('topic', 'T', RELIABLE_QOS, Publisher())
    prefix = os.urandom(12)
    one.receive(_announcement(prefix, user_data=b'x' * 400), STRANGER)
    network.keeps = True
    probe = Heartbeat(PUBLICATIONS_READER, PUBLICATIONS_WRITER, 1, 0, 1).encode()
    one.receive(header(prefix) + info_dst(one.prefix) + probe, STRANGER)
    assert any(write_endpoint(writer.data) in packet for *_, packet in network.packets)


def test_made_up_participants_do_not_shut_out_real_ones() -> None:
    network = Network()
    one, watcher = network.participant()
    other, _ = network.participant()
    network.run(0.2)
    assert other.prefix in watcher.participants
    for _ in range(3 * bounds.MOST_STRANGERS):
        one.receive(_announcement(os.urandom(12)), STRANGER)
    assert other.prefix in watcher.participants
    assert len(watcher.participants) == bounds.MOST_STRANGERS + 1
    assert watcher.refused['participant'] == 2 * bounds.MOST_STRANGERS
    third, _ = network.participant()
    assert network.run(1, lambda: third.prefix in watcher.participants)


def test_another_host_speaks_for_nobody_who_is_alive() -> None:
    network = Network()
    one, watcher = network.participant()
    other, _ = network.participant()
    publisher = Publisher()
    one.create_writer('t', 'T', RELIABLE_QOS, publisher)
    other.create_reader('t', 'T', RELIABLE_QOS, Collector())
    assert network.run(1, lambda: publisher.matched and watcher.endpoints)
    network.keeps = True
    other.close()
    leaving = [packet for *_, packet in network.packets]
    network = Network()
    one, watcher = network.participant()
    other, _ = network.participant()
    assert network.run(1, lambda: watcher.participants)
    for packet in [*leaving, _announcement(other.prefix)]:
        one.receive(packet, STRANGER)
    assert watcher.participants[other.prefix].metatraffic == (('10.0.0.2', 7410),)
    assert watcher.refused['packet in the name of another host'] == len(leaving) + 1


def test_a_participant_tells_of_its_own_endpoints_alone() -> None:
    network = Network()
    one, watcher = network.participant(settings={'peers': ()})
    prefix = os.urandom(12)
    one.receive(_announcement(prefix), STRANGER)
    foreign = EndpointData(os.urandom(12) + b'\0\0\1\3', 't', 'T', Qos())
    good = replace(foreign, guid=prefix + b'\0\0\1\3')
    for number, endpoint in enumerate([foreign, good], 1):
        data = Data(PUBLICATIONS_READER, PUBLICATIONS_WRITER, number, b'', write_endpoint(endpoint))
        beat = Heartbeat(PUBLICATIONS_READER, PUBLICATIONS_WRITER, 1, number, number)
        one.receive(header(prefix) + info_dst(one.prefix) + data.encode() + beat.encode(), STRANGER)
    assert list(watcher.endpoints.values()) == [good]
    assert watcher.refused['malformed announcement'] == 1


def test_malformed_packets_are_counted() -> None:
    network = Network()
    one, watcher = network.participant()
    for packet in (
        b'',
        b'RTPS',
        b'X' * 40,
        header(b'p' * 12)[:4] + b'\3' + bytes(20),
        header(b'p' * 12) + b'\x15\1',
    ):
        one.receive(packet, STRANGER)
    assert watcher.refused['malformed packet'] == 5


def test_early_samples_wait_until_their_writer_is_known() -> None:
    network = Network()
    one, watcher = network.participant(same_host=True)
    other, others_watcher = network.participant(same_host=True)
    assert network.run(1, lambda: watcher.participants and others_watcher.participants)
    collector = Collector()
    network.keeps = True
    writer = one.create_writer('t', 'T', RELIABLE_QOS, Publisher())
    reader = other.create_reader('t', 'T', RELIABLE_QOS, collector)
    data = Data(reader.entity_id, writer.entity_id, 1, b'', b'\0\1\0\0early')
    beat = Heartbeat(reader.entity_id, writer.entity_id, 1, 1, 1)
    packet = header(one.prefix) + info_dst(other.prefix) + data.encode() + beat.encode()
    other.receive(packet, ('10.0.0.1', 7410))
    assert not collector.samples
    assert network.run(0.001, lambda: collector.samples)
    assert [payload and payload[:9] for payload in collector.payloads] == [b'\0\1\0\0early']


def test_liveliness_of_a_topic_is_asserted_by_hand() -> None:
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    qos = Qos(liveliness=MANUAL_BY_TOPIC, lease=10**9)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', qos, publisher)
    other.create_reader('t', 'T', qos, collector)
    assert network.run(0.5, lambda: publisher.matched and collector.matched)
    for _ in range(4):
        network.run(0.6)
        writer.assert_liveliness()
    assert collector.liveliness == []
    network.run(1.5)
    assert collector.liveliness == [False]
    assert publisher.lost_liveliness >= 1
    writer.write(b'\0\1\0\0')
    network.run(0.1)
    assert collector.liveliness == [False, True]


def test_liveliness_is_automatic_while_a_participant_lives() -> None:
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    qos = Qos(lease=10**9)
    collector = Collector()
    one.create_writer('t', 'T', qos, Publisher())
    other.create_reader('t', 'T', qos, collector)
    assert network.run(0.5, lambda: collector.matched)
    network.run(10)
    assert collector.liveliness == []
    network.cut = lambda *_: True
    network.run(2)
    assert collector.liveliness == [False]


def test_deadlines_are_missed_on_both_sides() -> None:
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    qos = Qos(deadline=10**8)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', qos, publisher)
    other.create_reader('t', 'T', qos, collector)
    assert network.run(0.05, lambda: publisher.matched and collector.matched)
    for _ in range(10):
        writer.write(b'\0\1\0\0')
        network.run(0.05)
    assert (publisher.missed_deadlines, collector.missed_deadlines) == (0, 0)
    network.run(0.4)
    assert publisher.missed_deadlines >= 3
    assert collector.missed_deadlines >= 3


def test_samples_expire_by_their_lifespan() -> None:
    network = Network()
    one, _ = network.participant()
    qos = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL, depth=10, lifespan=10**9)
    writer = one.create_writer('t', 'T', qos, Publisher())
    writer.write(b'\0\1\0\0old ')
    network.run(0.8)
    writer.write(b'\0\1\0\0new ')
    network.run(0.3)
    other, _ = network.participant()
    collector = Collector()
    other.create_reader('t', 'T', qos, collector)
    assert network.run(0.5, lambda: collector.samples)
    assert collector.payloads == [b'\0\1\0\0new ']
