"""Writers and readers on a simulated network: where that is promised, nothing is lost or out of order."""

from __future__ import annotations

from functools import partial
from random import Random

import pytest
from helpers.rtps_network import Collector, Network, Publisher
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.records import replace
from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol.lingering import LINGER_S
from goalwire.rtps.protocol.participant import Participant
from goalwire.rtps.protocol.primitives import LARGE
from goalwire.rtps.protocol.qos import BEST_EFFORT, RELIABLE, TRANSIENT_LOCAL, Qos
from goalwire.rtps.protocol.reader import Sample
from goalwire.rtps.protocol.reader_proxy import HEARTBEAT_S, MOST_PATIENCE_S
from goalwire.rtps.protocol.writer import MOST_UNACKNOWLEDGED, Writer

KEEP_ALL = Qos(reliability=RELIABLE, depth=0)
PATIENCE_S = 60.0


def _payload(number: int, size: int = 0) -> bytes:
    return b'\0\1\0\0' + number.to_bytes(4, 'little') + bytes(size)


def test_a_topic_between_two_participants() -> None:
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('rt/chatter', 'String', KEEP_ALL, publisher)
    other.create_reader('rt/chatter', 'String', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    for number in range(10):
        assert writer.write(_payload(number)) == number + 1
    assert network.run(1, lambda: len(collector.samples) == 10)
    assert collector.payloads == [_payload(number) for number in range(10)]
    assert network.run(1, lambda: not writer.history.changes), 'all is acknowledged'


def test_who_has_shown_to_have_a_sample_is_not_asked_for_it() -> None:
    network = Network()
    one, _ = network.participant(settings={'announce_s': 1000.0})
    other, _ = network.participant(settings={'announce_s': 1000.0})
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    reader = other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(3)
    before = network.sent
    for number in range(1, 4):
        assert writer.write(_payload(number)) == number
        assert network.run(0.005, partial(_has, collector, number))
        one.run(partial(writer.note_received, reader.data.guid, number), None)
        network.run(1)
    assert network.sent == before + 3
    assert not writer.history.changes


def _meet_on_one_host(network: Network) -> tuple[Participant, Writer, Collector]:
    """Return a participant, its writer, and the collector of the reader that another participant has made."""
    one, _ = network.participant(settings={'announce_s': 1000.0}, same_host=True)
    other, _ = network.participant(settings={'announce_s': 1000.0}, same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(3)
    return one, writer, collector


def test_a_reader_on_this_host_that_lacks_nothing_is_seldom_asked() -> None:
    network = Network()
    _, writer, collector = _meet_on_one_host(network)
    before = network.sent
    for number in range(100):
        writer.write(_payload(number))
        network.run(0.02)
    assert network.sent < before + 160, 'a HEARTBEAT and an ACKNACK for each sample are 300 packets'
    assert collector.payloads == [_payload(number) for number in range(100)]
    network.run(0.2)
    assert not writer.history.changes


def test_a_reader_is_asked_at_once_if_a_caller_waits_for_its_answer() -> None:
    network = Network()
    one, writer, _ = _meet_on_one_host(network)
    for number in range(20):
        writer.write(_payload(number))
        network.run(0.2)
    writer.write(_payload(20))
    assert not network.run(0.03, writer.is_acknowledged), 'it is not asked for a while'
    one.ask_readers()
    assert network.run(0.001, writer.is_acknowledged)


def test_after_a_loss_a_reader_is_asked_soon_again() -> None:
    network = Network()
    _, writer, collector = _meet_on_one_host(network)

    def lose() -> float:
        """Write a sample whose first packet is lost, and return how long it takes."""
        begun, network.loss = network.now, 1.0
        number = writer.write(_payload(0)) or 0
        network.loss = 0.0
        assert network.run(1, partial(_has, collector, number))
        return network.now - begun

    for _ in range(20):
        writer.write(_payload(0))
        network.run(0.2)
    assert MOST_PATIENCE_S < lose() < 2 * MOST_PATIENCE_S
    assert lose() < 2.5 * HEARTBEAT_S


def test_a_writer_whose_readers_show_that_they_have_all_never_gets_full() -> None:
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    reader = other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(1)
    for number in range(3 * MOST_UNACKNOWLEDGED):
        written = writer.write(_payload(number))
        assert written is not None
        writer.note_received(reader.data.guid, written)  # no time passes: no reader is asked
    assert writer.is_acknowledged()
    assert writer.is_acknowledged_by_all()


def test_packets_that_are_read_together_are_taken_in_order() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(1)
    network.keeps, network.cut = True, lambda _from, _to: True
    sizes = [0, 50_000, 100_000, 0]
    for number, size in enumerate(sizes):
        writer.write(_payload(number, size))
    packets = [(packet, source) for _, source, _, packet in network.packets]
    other.receive_all([(packets[0][0][:-3], packets[0][1]), *packets])
    assert collector.payloads == [_payload(number, size) for number, size in enumerate(sizes)]


def test_a_match_takes_less_than_a_heartbeat_period() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    collector = Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    other.create_reader('t', 'T', KEEP_ALL, collector)
    begun = network.now
    assert network.run(1, lambda: collector.matched and writer.readers)
    assert network.now - begun < 0.005


def test_a_question_and_its_answer_never_wait_for_a_timer() -> None:
    """Each takes its two ways, while HEARTBEATs and announcements come and go."""
    network = Network()
    client, _ = network.participant()
    server, _ = network.participant()
    replies = Collector()
    reader = client.create_reader('rr/reply', 'Reply', KEEP_ALL, replies)
    requests = client.create_writer('rq/request', 'Request', KEEP_ALL, Publisher())
    answers = server.create_writer('rr/reply', 'Reply', KEEP_ALL, Publisher())
    asked = Collector()

    def answer(sample: Sample) -> None:
        answers.write(bytes(sample.payload or b''), to=reader.data.guid)

    asked.on_any = answer
    server.create_reader('rq/request', 'Request', KEEP_ALL, asked)
    assert network.run(1, lambda: requests.readers and answers.readers)
    network.run(1)
    network.sent = 0
    for number in range(500):
        begun = network.now
        requests.write(_payload(number))
        assert network.run(1, lambda: replies.samples)
        replies.samples.clear()
        assert network.now - begun == pytest.approx(100e-6)
        network.run(0.0002 if number % 100 else 3)
    assert network.sent < 1400, 'HEARTBEATs and their answers are few'


@pytest.mark.parametrize('same', [False, True])
def test_writers_and_readers_of_one_participant(same: bool) -> None:
    network = Network()
    one, _ = network.participant(starts=same)
    collector = Collector()
    one.create_reader('t', 'T', KEEP_ALL, collector)
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    for number in range(100):
        writer.write(_payload(number))
    assert collector.payloads == [_payload(number) for number in range(100)]
    one.delete(writer)
    assert collector.matched == []


def test_a_deleted_writer_goes_once_its_last_sample_has_arrived() -> None:
    network = Network()
    one, _ = network.participant(settings={'announce_s': 1000.0})
    other, watcher = network.participant(settings={'announce_s': 1000.0})
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(3)
    network.cut = lambda _from, _to: True
    writer.write(_payload(1))
    one.delete(writer)
    one.delete(writer)
    network.run(LINGER_S / 2)
    network.cut = lambda _from, _to: False
    assert network.run(LINGER_S / 2, lambda: not watcher.endpoints)
    assert collector.payloads == [_payload(1)]


def test_a_deleted_writer_waits_a_second_for_a_reader_that_is_silent() -> None:
    network = Network()
    one, writer, collector = _meet_on_one_host(network)
    network.cut = lambda _from, to: to == '10.0.0.1'
    writer.write(_payload(1))
    one.delete(writer)
    assert not network.run(LINGER_S - 0.01, lambda: not collector.matched)
    assert network.run(0.02, lambda: not collector.matched)


@settings(max_examples=10, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    loss=st.floats(0, 0.3),
    double=st.floats(0, 0.3),
    delay=st.sampled_from([0, 0.001, 0.02, 0.3]),
    size=st.sampled_from([0, 100, 70_000, 600_000]),
    depth=st.sampled_from([0, 1, 10]),
    durability=st.sampled_from([0, TRANSIENT_LOCAL]),
)
def test_reliable_readers_get_all_in_order(
    seed: int, loss: float, double: float, delay: float, size: int, depth: int, durability: int
) -> None:
    network = Network(seed, loss=loss, double=double, delay_s=delay)
    one, _ = network.participant()
    others = [network.participant()[0] for _ in range(2)]
    publisher = Publisher()
    qos = Qos(reliability=RELIABLE, durability=durability, depth=depth)
    writer = one.create_writer('t', 'T', qos, publisher)
    collectors = [Collector() for _ in others]
    for other, collector in zip(others, collectors, strict=True):
        other.create_reader('t', 'T', qos, collector)
    assert network.run(PATIENCE_S, lambda: len(publisher.matched) == 2 and all(c.matched for c in collectors))
    numbers = iter(range(8 if size else 60))

    def publish() -> None:
        for number in numbers:
            assert writer.write(_payload(number, size))
            network.at(network.now + network.random.choice([0, 0.0001, 0.05]), publish)
            return

    publish()
    last = _payload(7 if size else 59, size)
    assert network.run(PATIENCE_S * 5, lambda: all(c.last == last for c in collectors))
    sent = [_payload(number, size) for number in range(8 if size else 60)]
    for collector in collectors:
        if depth:
            assert collector.payloads == [payload for payload in sent if payload in collector.payloads]
            assert len(sent) >= len(collector.samples) + collector.lost
        else:
            assert collector.payloads == sent


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32), loss=st.floats(0, 0.3), delay=st.sampled_from([0, 0.02]))
def test_late_joiners_get_the_history_they_ask_for(seed: int, loss: float, delay: float) -> None:
    network = Network(seed, loss=loss, delay_s=delay)
    one, _ = network.participant()
    publisher = Publisher()
    latched = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL, depth=5)
    writer = one.create_writer('t', 'T', latched, publisher)
    for number in range(8):
        writer.write(_payload(number))
    other, _ = network.participant()
    latest, volatile = Collector(), Collector()
    other.create_reader('t', 'T', latched, latest)
    other.create_reader('t', 'T', replace(latched, durability=0), volatile)
    assert network.run(PATIENCE_S, lambda: len(latest.samples) == 5)
    assert latest.payloads == [_payload(number) for number in range(3, 8)]
    assert network.run(PATIENCE_S, lambda: len(publisher.matched) == 2)
    writer.write(_payload(8))
    assert network.run(PATIENCE_S, lambda: len(latest.samples) == 6 and volatile.samples)
    assert volatile.payloads == [_payload(8)]


def test_a_large_sample_that_was_written_before_its_readers_came_reaches_them() -> None:
    network = Network()
    one, _ = network.participant()
    latched = Qos(reliability=RELIABLE, durability=TRANSIENT_LOCAL, depth=1)
    writer = one.create_writer('t', 'T', latched, Publisher())
    writer.write(_payload(1, size=200_000))
    other, _ = network.participant()
    for _ in range(2):
        late = Collector()
        other.create_reader('t', 'T', latched, late)
        assert network.run(PATIENCE_S, lambda late=late: late.samples)  # type: ignore[misc]
        assert late.payloads == [_payload(1, size=200_000)]


def test_best_effort_readers_get_what_comes_in_order() -> None:
    network = Network(3, loss=0.2, double=0.2, delay_s=0.001)
    one, _ = network.participant()
    other, _ = network.participant()
    collector = Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    reader = other.create_reader('t', 'T', Qos(reliability=BEST_EFFORT), collector)
    assert network.run(PATIENCE_S, lambda: collector.matched and writer.readers)
    network.keeps = True
    for number in range(500):
        assert writer.write(_payload(number)), 'best effort never blocks'
        network.run(0.0002)
    network.run(1)
    numbers = [sample.number for sample in collector.samples]
    assert numbers == sorted(set(numbers))
    assert 200 < len(numbers) < 500
    assert not [
        packet for *_, packet in network.packets if reader.entity_id + writer.entity_id in packet[40:]
    ]


def test_a_large_sample_does_not_overrun_a_socket() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    collector = Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: collector.matched and writer.readers)
    network.keeps = True
    begun = network.now
    payload = bytes(range(256)) * 4096
    writer.write(payload)
    assert sum(len(packet) for *_, packet in network.packets) < 150_000
    assert network.run(1, lambda: collector.samples)
    assert network.now - begun < 0.01
    assert collector.payloads == [payload]
    assert sum(len(packet) for *_, packet in network.packets) < 1.1 * len(payload), 'nothing is sent twice'


def _windows_of(room: int, payload: bytes) -> list[float]:
    """Return when the packets of a sample leave for a reader on the same host whose buffer has `room`."""
    network = Network()
    settings: dict[str, object] = {'receive_buffer': room}
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True, settings=settings)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(1)
    network.keeps = True
    writer.write(payload)
    assert network.run(1, lambda: collector.samples)
    assert collector.payloads == [payload]
    return [when for when, _, _, packet in network.packets if len(packet) > LARGE]


def test_a_large_sample_goes_out_at_once_if_its_reader_has_room_for_it() -> None:
    payload = bytes(range(256)) * 4000
    assert len(set(_windows_of(8 << 20, payload))) == 1
    assert len(set(_windows_of(400_000, payload))) == 3
    assert len(set(_windows_of(0, payload))) == 4, 'two packets, then twice as many for each answer'


def test_a_window_grows_again_long_after_a_loss() -> None:
    network = Network()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)

    def count_windows() -> int:
        network.packets.clear()
        before = len(collector.samples)
        writer.write(bytes(2_000_000))
        assert network.run(5, lambda: len(collector.samples) > before)
        return len({when for when, _, _, packet in network.packets if len(packet) > LARGE})

    network.keeps = True
    for _ in range(4):
        fewest = count_windows()
    network.loss = 0.3
    for _ in range(4):
        count_windows()
    network.loss = 0
    assert count_windows() > fewest
    counts = [count_windows() for _ in range(60)]
    assert counts[-1] == fewest


def test_a_writer_that_keeps_all_is_full_until_its_readers_have_room() -> None:
    network = Network()
    one, _ = network.participant()
    slow, quick = network.participant()[0], network.participant()[0]
    publisher, slowly, quickly = Publisher(), Collector(), Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, publisher)
    reader = slow.create_reader('t', 'T', KEEP_ALL, slowly)
    quick.create_reader('t', 'T', KEEP_ALL, quickly)
    assert network.run(1, lambda: len(publisher.matched) == 2 and slowly.matched and quickly.matched)
    network.run(0.1)
    reader.pause()
    written = 0
    while writer.write(_payload(written)) is not None:
        written += 1
        network.run(0.0001)
    assert written >= 1000
    assert network.run(1, lambda: len(quickly.samples) == written), 'a slow reader holds up nobody else'
    assert not slowly.samples
    network.run(1)
    assert publisher.room == 0
    reader.resume()
    assert network.run(1, lambda: len(slowly.samples) == written)
    assert network.run(1, lambda: publisher.room == 1)
    assert slowly.payloads == quickly.payloads == [_payload(number) for number in range(written)]
    assert writer.write(_payload(written)) == written + 1


def test_a_partition_of_a_minute_heals() -> None:
    network = Network(5, loss=0.1)
    one, _ = network.participant(settings={'lease': 100 * 10**9})
    other, _ = network.participant(settings={'lease': 100 * 10**9})
    collector = Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(PATIENCE_S, lambda: collector.matched and writer.readers)
    for number in range(100):
        network.cut = lambda *_, number=number: 20 <= number < 80
        writer.write(_payload(number))
        network.run(1)
    network.cut = lambda *_: False
    assert network.run(10, lambda: len(collector.samples) == 100)
    assert collector.payloads == [_payload(number) for number in range(100)]


def test_an_addressed_sample_reaches_one_reader_and_holds_up_no_other() -> None:
    network = Network(1, loss=0.2)
    server, _ = network.participant()
    clients = [network.participant()[0] for _ in range(3)]
    collectors = [Collector() for _ in clients]
    publisher = Publisher()
    writer = server.create_writer('reply', 'T', KEEP_ALL, publisher)
    readers = [
        client.create_reader('reply', 'T', KEEP_ALL, collector)
        for client, collector in zip(clients, collectors, strict=True)
    ]
    assert network.run(PATIENCE_S, lambda: len(publisher.matched) == 3 and all(c.matched for c in collectors))
    for number in range(300):
        writer.write(_payload(number), to=readers[number % 3].data.guid)
        network.run(0.001)
    writer.write(_payload(300))
    assert network.run(PATIENCE_S, lambda: all(c.payloads[-1:] == [_payload(300)] for c in collectors))
    for at, collector in enumerate(collectors):
        assert collector.payloads == [_payload(number) for number in range(300) if number % 3 == at] + [
            _payload(300)
        ]
        assert collector.lost == 0
    assert network.run(PATIENCE_S, lambda: not writer.history.changes)


def test_a_sample_says_to_which_request_it_belongs() -> None:
    from goalwire.rtps.protocol.parameters import write_related_sample
    from goalwire.rtps.protocol.primitives import SampleIdentity

    network = Network()
    one, _ = network.participant()
    collector = Collector()
    one.create_reader('t', 'T', KEEP_ALL, collector)
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    request = SampleIdentity(b'g' * 16, 2**33)
    writer.write(_payload(1), qos=write_related_sample(request))
    writer.write(_payload(1, 100_000), qos=write_related_sample(request))
    assert network.run(1, lambda: len(collector.samples) == 2)
    assert [sample.related for sample in collector.samples] == [request, request]


@pytest.mark.parametrize('seed', range(4))
def test_a_sample_is_kept_while_it_is_being_sent(seed: int) -> None:
    network = Network(seed, loss=0.2)
    one, _ = network.participant()
    other, _ = network.participant()
    collector = Collector()
    writer = one.create_writer('t', 'T', KEEP_ALL, Publisher())
    other.create_reader('t', 'T', KEEP_ALL, collector)
    assert network.run(PATIENCE_S, lambda: collector.matched and writer.readers)
    for number in range(5):
        writer.write(_payload(number))
        writer.write(_payload(number, 900_000))
        network.run(0.02)
    assert network.run(PATIENCE_S, lambda: len(collector.samples) == 10)
    assert collector.lost == 0


def test_a_reader_that_holds_back_all_that_it_may_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, 'AHEAD_SIZE', 5000)
    network = Network()
    one, _ = network.participant()
    other, _ = network.participant()
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', Qos(reliability=RELIABLE, depth=100), publisher)
    other.create_reader('t', 'T', Qos(reliability=RELIABLE, depth=100), collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(0.2)
    network.loss = 1
    writer.write(bytes(1000))
    network.loss = 0
    for _ in range(20):
        writer.write(bytes(1000))
    assert network.run(5, lambda: len(collector.samples) == 21)


def _has(collector: Collector, count: int) -> bool:
    return len(collector.samples) == count


def _sizes_to_a_far_reader(loses: bool) -> list[int]:
    """Send three samples of 4 MB to another host, and return the largest packet of each."""
    network = Network(3)
    one, _ = network.participant()
    other, _ = network.participant()
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', Qos(reliability=RELIABLE, depth=10), publisher)
    other.create_reader('t', 'T', Qos(reliability=RELIABLE, depth=10), collector)
    assert network.run(1, lambda: publisher.matched and collector.matched)
    network.run(0.2)
    network.keeps = True
    network.loss = 0.05 if loses else 0
    sizes = []
    for number in range(1, 4):
        network.packets.clear()
        writer.write(bytes(4_000_000))
        assert network.run(60, partial(_has, collector, number))
        sizes.append(max(len(packet) for _, source, _, packet in network.packets if source[0] == '10.0.0.1'))
    return sizes


def test_fragments_to_another_host_grow_when_much_has_arrived() -> None:
    first, _, last = _sizes_to_a_far_reader(loses=False)
    assert first < 1472, 'no network cuts these'
    assert last > 8000


def test_fragments_to_another_host_stay_small_where_packets_are_lost() -> None:
    assert max(_sizes_to_a_far_reader(loses=True)) < 1472


class Steady(Random):
    """Lets every packet take the same time."""

    def random(self) -> float:
        return 0.5


def test_fragments_that_cross_with_what_asks_for_them_are_not_lost() -> None:
    network = Network(delay_s=0.002)
    network.random = Steady()
    one, _ = network.participant(same_host=True)
    other, _ = network.participant(same_host=True)
    publisher, collector = Publisher(), Collector()
    writer = one.create_writer('t', 'T', Qos(reliability=RELIABLE, depth=10), publisher)
    other.create_reader('t', 'T', Qos(reliability=RELIABLE, depth=10), collector)
    assert network.run(1, lambda: publisher.matched and collector.answered)
    network.keeps = True
    for number in range(1, 6):
        writer.write(bytes(1_000_000))
        assert network.run(1, lambda number=number: len(collector.samples) == number)  # type: ignore[misc]
    large = [packet for _, _, _, packet in network.packets if len(packet) > 30_000]
    assert len(large) == 5 * 17
