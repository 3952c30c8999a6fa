"""Subscriptions with history."""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterator
from typing import TypeVar

import pytest
import zenoh
from helpers.collector import Collector
from helpers.patience import PATIENCE, wait_for
from helpers.wire import HASH, Side
from zenoh import ext

from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy
from goalwire.transport.contract import EndpointKind, Sample
from goalwire.transport.zenoh import subscription, wire
from goalwire.transport.zenoh.session import ZenohSession
from goalwire.transport.zenoh.settings.environment import CHOICE, NATIVE

from .conftest import on_both, open_peer

pytestmark = on_both

T = TypeVar('T')
LASTING = QoS(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
MAP = f'/map/std_msgs::msg::dds_::String_/{HASH}'


GID = bytes(range(16))


def beside(number: int) -> bytes:
    """The attachment of a publisher's message, counted from 0 as the wire does."""
    return struct.pack('<qqB', number + 1, 1, 16) + GID


def direct(take: Callable[[T], object]) -> zenoh.handlers.Callback[T]:
    return zenoh.handlers.Callback(take, indirect=False)


class TheirPublisher:
    """A publisher whose history is zenoh's own, but whose messages and token go out when the test says so."""

    def __init__(self, peer: zenoh.Session, key: str) -> None:
        self.asked: Collector[str] = Collector()
        self._peer = peer
        self._key = key
        self._cache = ext.declare_advanced_publisher(
            peer,
            key,
            allowed_destination=zenoh.Locality.SESSION_LOCAL,
            cache=ext.CacheConfig(10),
            sample_miss_detection=ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=None),
        )
        self.source = self._cache.id
        self.address = f'{key}/@adv/pub/{self.source.zid}/{self.source.eid}/_'
        self._listener = peer.declare_queryable(self.address, direct(self._on_query))
        self._token: zenoh.LivelinessToken | None = None

    def show(self) -> None:
        """Declare the token."""
        self._token = self._peer.liveliness().declare_token(self.address)

    def keep(self, *numbers: int) -> None:
        """Take messages into the history, from 0 on."""
        for number in numbers:
            self._cache.put(b'%d' % number, attachment=beside(number))

    def send(self, *numbers: int) -> None:
        """Send messages."""
        for number in numbers:
            source = zenoh.SourceInfo(self.source, number)
            self._peer.put(self._key, b'%d' % number, attachment=beside(number), source_info=source)

    def beat(self, number: int) -> None:
        """Say which message was the last."""
        self._peer.put(self.address, ext.z_serialize(ext.UInt32(number)))

    def _on_query(self, query: zenoh.Query) -> None:
        self.asked(str(query.parameters).partition(';')[0])
        query.drop()  # type: ignore[no-untyped-call]


@pytest.fixture
def key(world: dict[str, str]) -> str:
    return world['ROS_DOMAIN_ID'] + MAP


def await_subscriber(session: zenoh.Session, key: str) -> None:
    """Wait until a session knows the subscription: before that, zenoh sends its messages to nobody."""
    shown: Collector[zenoh.Sample] = Collector()
    session.liveliness().declare_subscriber(f'{key}/@adv/sub/**', direct(shown), history=True)
    shown.expect()


@pytest.fixture
def samples(goalwire_side: Side, peer: zenoh.Session, key: str) -> Collector[Sample]:
    """The samples that a subscription gets; the peer has seen the subscription already."""
    came: Collector[Sample] = Collector()
    goalwire_side.subscription('/map', came, LASTING)
    await_subscriber(peer, key)
    return came


@pytest.fixture
def theirs(peer: zenoh.Session, key: str, samples: Collector[Sample]) -> TheirPublisher:
    return TheirPublisher(peer, key)


def arrived(samples: Collector[Sample], number: int) -> list[bytes]:
    return [bytes(sample.payload) for sample in samples.expect(number)]


def test_a_message_that_comes_before_the_history_does_not_hide_it(
    samples: Collector[Sample], theirs: TheirPublisher
) -> None:
    theirs.keep(0, 1, 2, 3)
    theirs.send(3)
    theirs.show()
    theirs.send(4)
    assert arrived(samples, 5) == [b'0', b'1', b'2', b'3', b'4']


def test_a_publisher_that_comes_late_is_asked_for_its_history(
    samples: Collector[Sample], theirs: TheirPublisher
) -> None:
    theirs.keep(0, 1, 2)
    theirs.show()
    assert theirs.asked.expect() == ['_max=10']
    assert arrived(samples, 3) == [b'0', b'1', b'2']


def test_messages_lost_on_the_way_are_asked_for_by_their_numbers(
    samples: Collector[Sample], theirs: TheirPublisher
) -> None:
    theirs.keep(0, 1, 2, 3)
    theirs.send(0, 3)
    assert arrived(samples, 4) == [b'0', b'1', b'2', b'3']
    assert theirs.asked.expect() == ['_sn=1..']


def test_a_heartbeat_brings_the_last_message_back(samples: Collector[Sample], theirs: TheirPublisher) -> None:
    theirs.keep(0, 1)
    theirs.send(0)
    theirs.beat(1)
    assert arrived(samples, 2) == [b'0', b'1']
    assert theirs.asked.expect() == ['_sn=1..1']


def test_a_publisher_that_keeps_nothing_is_heard(
    samples: Collector[Sample], peer: zenoh.Session, key: str
) -> None:
    for number in (7, 8):
        peer.put(key, b'%d' % number, attachment=beside(number))
    assert arrived(samples, 2) == [b'7', b'8']


@pytest.fixture
def forger(world: dict[str, str], peer: zenoh.Session) -> Iterator[zenoh.Session]:
    """A peer that is linked to each of the others.

    Without these links the router passes its tokens on, and the questions that others ask do not come.
    """
    with open_peer(world) as session:
        wait_for(lambda: len(session.info.peers_zid()) == 2, 'links to both')
        yield session


def test_one_message_in_a_publishers_name_does_not_silence_it(
    samples: Collector[Sample],
    theirs: TheirPublisher,
    forger: zenoh.Session,
    key: str,
    goalwire_side: Side,
    world: dict[str, str],
) -> None:
    theirs.keep(0, 1, 2)
    theirs.send(0, 1, 2)
    arrived(samples, 3)
    await_subscriber(forger, key)
    far = zenoh.SourceInfo(theirs.source, 2_000_000_000)
    forger.put(key, b'forged', attachment=beside(2_000_000_000), source_info=far)
    if world[CHOICE] == NATIVE:  # a session of ours sees over which link it came
        ours = goalwire_side.session
        assert isinstance(ours, ZenohSession)
        wait_for(lambda: ours.statistics().get('forged message') == 1, 'the refusal')
    else:
        assert arrived(samples, 4)[3] == b'forged'
    theirs.keep(3, 4)
    theirs.send(3, 4)
    expected = [b'0', b'1', b'2', b'3', b'4']
    came = arrived(samples, 5 + (world[CHOICE] != NATIVE))
    assert [each for each in came if each != b'forged'] == expected


def test_a_stranger_that_never_answers_for_a_publisher_does_not_hold_its_messages_up(
    samples: Collector[Sample],
    theirs: TheirPublisher,
    forger: zenoh.Session,
    monkeypatch: pytest.MonkeyPatch,
    world: dict[str, str],
    key: str,
) -> None:
    """A session that is linked to the publisher asks nobody else. eclipse-zenoh's asks everybody: there its
    messages wait for HISTORY_S, and then for the next one."""
    held: list[zenoh.Query] = []
    theirs.keep(0, 1, 2)  # before the token: eclipse-zenoh's session asks as soon as it sees one
    forger.declare_queryable(theirs.address, direct(held.append))
    await_subscriber(forger, key)
    forger.put(key, b'asked', attachment=beside(7))  # it comes after the queryable, so the token does too
    arrived(samples, 1)
    forger.liveliness().declare_token(theirs.address)
    theirs.send(2)
    theirs.show()
    arrived(samples, 4)
    theirs.send(3)
    if world[CHOICE] != NATIVE:
        wait_for(lambda: held, 'the question')
        monkeypatch.setattr(wire, 'HISTORY_S', 0.0)
    theirs.send(4)
    assert arrived(samples, 6) == [b'asked', b'0', b'1', b'2', b'3', b'4']


class Gate:
    """A publisher without numbers of the wire that answers, after `hold`, with one message."""

    def __init__(self, peer: zenoh.Session, key: str, hold: Callable[[], object]) -> None:
        self.answered = threading.Event()
        self._key = key
        self._hold = hold
        address = f'{key}/@adv/pub/{peer.zid()}/uhlc/_'
        self._queryable = peer.declare_queryable(address, direct(self._on_query))
        self._token = peer.liveliness().declare_token(address)

    def _on_query(self, query: zenoh.Query) -> None:
        self._hold()
        query.reply(self._key, b'0', attachment=beside(0))
        query.drop()  # type: ignore[no-untyped-call]
        self.answered.set()


def test_a_message_that_is_published_while_the_history_is_awaited_comes_after_it(
    samples: Collector[Sample], peer: zenoh.Session, key: str
) -> None:
    Gate(peer, key, lambda: peer.put(key, b'1', attachment=beside(1)))
    assert arrived(samples, 2) == [b'0', b'1']


def test_a_subscription_closed_while_the_history_is_awaited_gets_nothing(
    goalwire_side: Side, peer: zenoh.Session, key: str
) -> None:
    asked, closed = threading.Event(), threading.Event()

    def hold() -> None:
        asked.set()
        assert closed.wait(PATIENCE)

    gate = Gate(peer, key, hold)
    came: Collector[Sample] = Collector()
    port = goalwire_side.subscription('/map', came, LASTING)
    assert asked.wait(PATIENCE)
    port.close()
    closed.set()
    assert gate.answered.wait(PATIENCE)
    goalwire_side.session.close()
    assert came.items == []


def test_two_best_effort_publishers_of_one_session_are_both_asked(open_side: Callable[[str], Side]) -> None:
    ours, other = open_side('ours'), open_side('other')
    qos = QoS(
        depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.BEST_EFFORT
    )
    for name in (b'a', b'b'):
        publisher = other.publisher('/map', qos)
        publisher.publish(name + b'0')
        publisher.publish(name + b'1')
    ours.graph.expect(EndpointKind.PUBLISHER, '/map', 2)
    samples: Collector[Sample] = Collector()
    ours.subscription('/map', samples, qos)
    came = arrived(samples, 4)
    assert [text for text in came if text.startswith(b'a')] == [b'a0', b'a1']
    assert [text for text in came if text.startswith(b'b')] == [b'b0', b'b1']


def test_a_subscription_that_ignores_its_own_session_gets_no_history_from_there(
    open_side: Callable[[str], Side],
) -> None:
    ours, other = open_side('ours'), open_side('other')
    for side, text in ((ours, b'ours'), (other, b'theirs')):
        side.publisher('/map', LASTING).publish(text)
    ours.graph.expect(EndpointKind.PUBLISHER, '/map', 2)
    samples: Collector[Sample] = Collector()
    ours.subscription('/map', samples, LASTING, ignore_local=True)
    assert arrived(samples, 1) == [b'theirs']


def test_publishers_that_have_gone_are_forgotten_at_last(
    open_side: Callable[[str], Side], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(subscription, 'KEPT_STREAMS', 3)
    ours = open_side('ours')
    samples: Collector[Sample] = Collector()
    ours.subscription('/map', samples, LASTING)
    for number in range(8):
        publisher = ours.publisher('/map', LASTING)
        publisher.publish(b'%d' % number)
        publisher.close()
    assert arrived(samples, 8) == [b'%d' % number for number in range(8)]
