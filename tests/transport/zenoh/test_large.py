"""Messages larger than what a link's queue holds, to a plain zenoh peer that is slow or stands still."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
import zenoh
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.wire import HASH, Side

from goalwire.errors import TransportError
from goalwire.logging import LogRecord
from goalwire.rules.qos import HistoryPolicy, QoS, ReliabilityPolicy
from goalwire.transport.contract import EndpointKind
from goalwire.transport.zenoh import publisher

REST = f'std_msgs::msg::dds_::String_/{HASH}'
MEGABYTE = 1 << 20
BEST_EFFORT = QoS(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


class Reader:
    """A subscriber that takes a message when it may; the number of each is its first byte."""

    def __init__(self, peer: zenoh.Session, domain: str) -> None:
        self.may_go_on = threading.Event()
        self.may_go_on.set()
        self.pause = 0.0
        self.came: Collector[int] = Collector()
        handler = zenoh.handlers.Callback(self._take, indirect=False)
        self._subscriber = peer.declare_subscriber(f'{domain}/chatter/{REST}', handler)
        token = f'@ros2_lv/{domain}/{peer.zid()}/0/1/MS/%/%/theirs/%chatter/{REST}/::,10:,:,:,,'
        self._token = peer.liveliness().declare_token(token)

    def _take(self, sample: zenoh.Sample) -> None:
        self.came(sample.payload.to_bytes()[0])
        self.may_go_on.wait(PATIENCE)
        threading.Event().wait(self.pause)


@pytest.fixture
def reader(goalwire_side: Side, peer: zenoh.Session, world: dict[str, str]) -> Iterator[Reader]:
    """The peer's subscriber, known to our side."""
    reader = Reader(peer, world['ROS_DOMAIN_ID'])
    goalwire_side.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter')  # declared after the subscriber
    yield reader
    reader.may_go_on.set()


def numbered(number: int, megabytes: int = 8) -> bytes:
    return bytes((number,)) + bytes(megabytes * MEGABYTE)


def small(number: int) -> bytes:
    return bytes((number,))


def test_a_slow_reader_gets_all_that_the_history_holds(goalwire_side: Side, reader: Reader) -> None:
    reader.pause = 0.1  # Zenoh gives a message up after half of that
    port = goalwire_side.publisher('/chatter', QoS(depth=10))
    for number in range(10):
        port.publish(numbered(number))
    assert reader.came.expect(10) == list(range(10))
    assert port.port.dropped == 0


def test_small_messages_do_not_overtake_large_ones(goalwire_side: Side, reader: Reader) -> None:
    reader.pause = 0.05
    port, other = (goalwire_side.publisher('/chatter', QoS(depth=10)) for _ in range(2))
    everything = goalwire_side.publisher('/chatter', QoS(history=HistoryPolicy.KEEP_ALL))
    for number in range(0, 12, 4):
        port.publish(numbered(number))
        port.publish(small(number + 1))
        other.publish(small(number + 2))
        everything.publish(small(number + 3))
    assert reader.came.expect(12) == list(range(12))


def test_what_the_history_does_not_hold_is_counted_and_logged_once(
    goalwire_side: Side, reader: Reader, records: list[LogRecord]
) -> None:
    reader.may_go_on.clear()
    port = goalwire_side.publisher('/chatter', QoS(depth=2))
    for number in range(10):
        port.publish(numbered(number))
    dropped = port.port.dropped
    assert 5 <= dropped <= 7  # two wait, one is being sent, and the first have gone
    (record,) = records
    assert "'/chatter'" in record.message
    assert f'a message of {8 * MEGABYTE + 1} bytes was dropped' in record.message
    assert 'history depth' in record.message
    reader.may_go_on.set()
    came = reader.came.expect(10 - dropped)
    assert came[-2:] == [8, 9]
    assert came == sorted(came)


def test_keep_all_waits_and_drops_nothing(goalwire_side: Side, reader: Reader) -> None:
    reader.may_go_on.clear()
    port = goalwire_side.publisher('/chatter', QoS(history=HistoryPolicy.KEEP_ALL))
    published: Collector[int] = Collector()

    def publish_all() -> None:
        for number in range(6):
            port.publish(numbered(number))
            published(number)

    thread = threading.Thread(target=publish_all)
    thread.start()
    reader.came.expect(1)
    assert len(published.items) < 6
    reader.may_go_on.set()
    thread.join(PATIENCE)
    assert reader.came.expect(6) == list(range(6))
    assert port.port.dropped == 0


def test_a_publisher_that_is_closed_sends_what_waits(goalwire_side: Side, reader: Reader) -> None:
    reader.pause = 0.1
    port = goalwire_side.publisher('/chatter', QoS(depth=10))
    for number in range(4):
        port.publish(numbered(number))
    port.close()
    assert reader.came.expect(4) == list(range(4))


def test_closing_does_not_wait_for_ever_for_who_stands_still(
    goalwire_side: Side, reader: Reader, records: list[LogRecord], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(publisher, 'LEAVING_S', 0.2)
    reader.may_go_on.clear()
    port = goalwire_side.publisher('/chatter', QoS(depth=10))
    assert isinstance(port.port, publisher.ZenohPublisher)
    for number in range(6):
        port.publish(numbered(number, 16))
    port.close()
    assert 3 <= port.port.dropped <= 5
    (record,) = records
    assert 'had not gone 0.2 s after the publisher was closed' in record.message
    reader.may_go_on.set()
    port.port._turn.wait()  # else the session's closing waits for the one message that is being sent


def test_what_no_peer_can_receive_is_refused(goalwire_side: Side, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publisher, 'LARGEST', MEGABYTE)
    for qos in (QoS(), BEST_EFFORT, QoS(history=HistoryPolicy.KEEP_ALL)):
        port = goalwire_side.publisher('/chatter', qos)
        with pytest.raises(TransportError, match=r"'/chatter': a message of 2097153 bytes cannot be sent"):
            port.publish(numbered(1, 2))


def test_a_best_effort_publisher_waits_for_nobody(goalwire_side: Side, reader: Reader) -> None:
    reader.may_go_on.clear()
    port = goalwire_side.publisher('/chatter', BEST_EFFORT)
    for number in range(20):
        port.publish(numbered(number))
    assert len(reader.came.items) <= 1
    assert port.port.dropped == 0  # those are zenoh's own, of which it does not tell
