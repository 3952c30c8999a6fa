"""The bytes on the wire, judged by a plain zenoh program written from rmw_zenoh's documents alone."""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable
from typing import TypeVar

import pytest
import xxhash
import zenoh
from helpers.collector import Collector
from helpers.patience import PATIENCE, wait_for
from helpers.wire import HASH, Answers, Side
from zenoh import ext

from goalwire.logging import LogRecord
from goalwire.rules.qos import DurabilityPolicy, QoS
from goalwire.transport.contract import Endpoint, EndpointKind, Request, Sample
from goalwire.transport.zenoh.session import ZenohSession

from .conftest import on_both

pytestmark = on_both

T = TypeVar('T')
CHATTER = f'/chatter/std_msgs::msg::dds_::String_/{HASH}'
ADD = f'/add/example_interfaces::srv::dds_::AddTwoInts_/{HASH}'
LASTING = QoS(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PEER_GID = bytes(range(100, 116))


def direct(collect: Collector[T]) -> zenoh.handlers.Callback[T]:
    return zenoh.handlers.Callback(collect, indirect=False)


def beside(sequence: int, gid: bytes = PEER_GID) -> bytes:
    """An attachment as rmw_zenoh packs it."""
    return struct.pack('<qqB', sequence, time.time_ns(), 16) + gid


def unpack(attachment: zenoh.ZBytes | None) -> tuple[int, int, int, bytes]:
    assert attachment is not None
    data = attachment.to_bytes()
    assert len(data) == 33
    sequence, timestamp, size = struct.unpack_from('<qqB', data)
    return sequence, timestamp, size, data[17:]


def expect_last(collector: Collector[T], is_last: Callable[[T], bool]) -> list[T]:
    """Wait for one item and return all up to it.

    On a busy machine a message may still be under way when a late subscription comes, which then gets it too.
    """
    items = collector.expect()
    while not is_last(items[-1]):
        items = collector.expect(len(items) + 1)
    return items


def hashed(token: str) -> bytes:
    return xxhash.xxh3_128(token.encode()).intdigest().to_bytes(16, 'little')


@pytest.fixture
def domain(world: dict[str, str]) -> str:
    return world['ROS_DOMAIN_ID']


class PeerNode:
    """A node of the plain peer: shows itself by tokens that the test spells out."""

    def __init__(self, peer: zenoh.Session, domain: str) -> None:
        self._liveliness = peer.liveliness()
        self._head = f'@ros2_lv/{domain}/{peer.zid()}'
        self._tokens = [self._liveliness.declare_token(f'{self._head}/0/0/NN/%/%/theirs')]

    def show(self, code: str, name: str, type_and_hash: str, qos: str = '::,10:,:,:,,') -> str:
        """Declare an endpoint's token and return it."""
        token = f'{self._head}/0/1/{code}/%/%/theirs/%{name}/{type_and_hash}/{qos}'
        self._tokens.append(self._liveliness.declare_token(token))
        return token


@pytest.fixture
def peer_node(peer: zenoh.Session, domain: str) -> PeerNode:
    return PeerNode(peer, domain)


STRING_REST = f'std_msgs::msg::dds_::String_/{HASH}'
ADD_REST = f'example_interfaces::srv::dds_::AddTwoInts_/{HASH}'


def test_a_peer_hears_what_we_publish(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    heard: Collector[zenoh.Sample] = Collector()
    peer.declare_subscriber(domain + CHATTER, direct(heard))
    peer_node.show('MS', 'chatter', STRING_REST)
    publisher = goalwire_side.publisher('/chatter')
    goalwire_side.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter')
    before = time.time_ns()
    publisher.publish(b'\x00\x01\x00\x00hello')
    sample = heard.expect()[0]
    sequence, timestamp, size, gid = unpack(sample.attachment)
    assert sample.payload.to_bytes() == b'\x00\x01\x00\x00hello'
    assert str(sample.key_expr) == domain + CHATTER
    assert (sequence, size, gid) == (1, 16, publisher.gid)
    assert before <= timestamp <= time.time_ns()


def test_we_hear_what_a_peer_publishes(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    samples: Collector[Sample] = Collector()
    goalwire_side.subscription('/chatter', samples)
    token = peer_node.show('MP', 'chatter', STRING_REST)
    seen = goalwire_side.graph.expect(EndpointKind.PUBLISHER, '/chatter')[0]
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**/MS/**', direct(tokens), history=True)
    tokens.expect()
    peer.put(domain + CHATTER, b'payload', attachment=beside(7, hashed(token)))
    sample = samples.expect()[0]
    assert (sample.payload, sample.sequence, sample.gid) == (b'payload', 7, seen.gid)
    assert 0 < sample.source_timestamp <= sample.received_timestamp


def test_our_tokens_read_as_the_design_says(goalwire_side: Side, peer: zenoh.Session, domain: str) -> None:
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**', direct(tokens), history=True)
    port = goalwire_side.publisher('/chatter', QoS(depth=7))
    texts = [str(sample.key_expr) for sample in tokens.expect(2)]
    node = next(text for text in texts if '/NN/' in text)
    head, _, rest = node.partition('/NN/')
    zid = head.split('/')[2]
    assert (head, rest) == (f'@ros2_lv/{domain}/{zid}/0/0', '%/%/ours')
    assert f'@ros2_lv/{domain}/{zid}/0/1/MP/%/%/ours/%chatter/{STRING_REST}/::,7:,:,:,,' in texts
    assert port.gid == hashed(next(text for text in texts if '/MP/' in text))


def test_a_peer_gets_our_answer(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    requests: Collector[Request] = Collector()
    goalwire_side.service('/add', requests)
    replies: Collector[zenoh.Reply] = Collector()
    done = threading.Event()
    querier = peer.declare_querier(
        domain + ADD, target=zenoh.QueryTarget.ALL_COMPLETE, consolidation=zenoh.ConsolidationMode.NONE
    )
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**/SS/**', direct(tokens), history=True)
    tokens.expect()
    handler = zenoh.handlers.Callback(replies, drop=done.set, indirect=False)
    querier.get(handler, payload=b'two and two', attachment=beside(3))
    request = requests.expect()[0]
    assert request.sample[:2] == (b'two and two', 3)
    assert request.sample.gid == PEER_GID
    request.reply(b'four')
    answer = replies.expect()[0].ok
    assert answer is not None
    assert answer.payload.to_bytes() == b'four'
    assert str(answer.key_expr) == domain + ADD
    sequence, _, size, gid = unpack(answer.attachment)
    assert (sequence, size, gid) == (3, 16, PEER_GID)
    assert done.wait(PATIENCE), 'the query was not let go'


def test_we_get_a_peers_answer(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    asked: Collector[tuple[bytes, tuple[int, int, int, bytes]]] = Collector()

    def serve(query: zenoh.Query) -> None:
        assert query.payload is not None
        assert query.attachment is not None
        sequence, _, _, gid = unpack(query.attachment)
        asked((query.payload.to_bytes(), unpack(query.attachment)))
        query.reply(domain + ADD, b'four', attachment=beside(sequence, gid))
        query.drop()  # type: ignore[no-untyped-call]

    peer.declare_queryable(domain + ADD, zenoh.handlers.Callback(serve, indirect=False), complete=True)
    peer_node.show('SS', 'add', ADD_REST)
    client = goalwire_side.client('/add')
    goalwire_side.graph.expect(EndpointKind.SERVICE, '/add')
    answers = Answers()
    assert answers.ask(client, b'two and two') == 1
    reply = answers.expect(replies=1)[0]
    assert (reply.payload, reply.sequence, reply.gid) == (b'four', 1, client.gid)
    payload, (sequence, _, size, gid) = asked.items[0]
    assert (payload, sequence, size, gid) == (b'two and two', 1, 16, client.gid)


def test_a_queryable_that_is_not_complete_is_not_asked(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    asked: Collector[zenoh.Query] = Collector()
    peer.declare_queryable(domain + ADD, direct(asked), complete=False)
    peer_node.show('SS', 'add', ADD_REST)
    client = goalwire_side.client('/add')
    goalwire_side.graph.expect(EndpointKind.SERVICE, '/add')
    answers = Answers()
    answers.ask(client)
    answers.expect(replies=0)
    assert asked.items == []


def test_a_late_peer_gets_our_history(goalwire_side: Side, peer: zenoh.Session, domain: str) -> None:
    publisher = goalwire_side.publisher('/chatter', LASTING)
    for text in (b'1', b'2', b'3'):
        publisher.publish(text)
    # A peer that has just been met may get them all the same; they are past it once a query is answered.
    wait_for(lambda: list(peer.get(f'{domain}{CHATTER}/@adv/**?_anyke')), 'the history')
    heard: Collector[zenoh.Sample] = Collector()
    ext.declare_advanced_subscriber(
        peer,
        domain + CHATTER,
        direct(heard),
        history=ext.HistoryConfig(detect_late_publishers=True, max_samples=2),
        recovery=ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
        subscriber_detection=True,
    )
    samples = expect_last(heard, lambda sample: sample.payload.to_bytes() == b'3')
    assert [sample.payload.to_bytes() for sample in samples[-2:]] == [b'2', b'3']
    assert [unpack(sample.attachment)[0] for sample in samples[-2:]] == [2, 3]


def test_we_get_the_history_of_a_peer(goalwire_side: Side, peer: zenoh.Session, domain: str) -> None:
    publisher = ext.declare_advanced_publisher(
        peer,
        domain + CHATTER,
        cache=ext.CacheConfig(2),
        sample_miss_detection=ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=0.5),
        publisher_detection=True,
    )
    for number in (1, 2, 3):
        publisher.put(str(number).encode(), attachment=beside(number))
    samples: Collector[Sample] = Collector()
    goalwire_side.subscription('/chatter', samples, LASTING)
    came = expect_last(samples, lambda sample: sample.payload == b'3')
    assert [sample.payload for sample in came[-2:]] == [b'2', b'3']


@pytest.mark.parametrize('channel', ['', '/_buf_cpu'])
def test_a_subscription_to_buffers_hears_either_channel(
    goalwire_side: Side, peer: zenoh.Session, domain: str, channel: str
) -> None:
    samples: Collector[Sample] = Collector()
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**/MS/**', direct(tokens), history=True)
    image = Endpoint(
        EndpointKind.SUBSCRIPTION, '/chatter', 'std_msgs/msg/String', HASH, QoS(), has_buffers=True
    )
    goalwire_side.node.subscription(image, samples)
    assert str(tokens.expect()[0].key_expr).endswith('/::,10:,:,:,,/backends:cpu:')
    peer.put(domain + CHATTER + channel, b'pixels', attachment=beside(1))
    assert [sample.payload for sample in samples.expect()] == [b'pixels']


def statistics(side: Side) -> dict[str, int]:
    assert isinstance(side.session, ZenohSession)
    return side.session.statistics()


def test_messages_with_broken_attachments_are_counted_and_logged_once(
    goalwire_side: Side, peer: zenoh.Session, domain: str, records: list[LogRecord]
) -> None:
    samples: Collector[Sample] = Collector()
    goalwire_side.subscription('/chatter', samples)
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**/MS/**', direct(tokens), history=True)
    tokens.expect()
    for attachment in (None, b'', b'short', bytes(77), beside(1)[:-1], beside(-1)):
        peer.put(domain + CHATTER, b'lost', attachment=attachment)
    peer.put(domain + CHATTER, b'good', attachment=beside(1))
    assert [sample.payload for sample in samples.expect()] == [b'good']
    assert statistics(goalwire_side) == {'message': 6}
    assert [record.message.count('/chatter') for record in records] == [1]


def test_tokens_that_break_the_grammar_are_counted(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    tokens = [
        peer.liveliness().declare_token(f'@ros2_lv/{domain}/{rest}') for rest in ('x', 'a/0/1/XX/%/%/n')
    ]
    peer_node.show('MP', 'chatter', STRING_REST, qos='nonsense')
    peer_node.show('MP', 'chat\nter', STRING_REST)
    peer_node.show('MP', 'chatter', STRING_REST[:-9] + '\x1b[2Jforge')
    peer_node.show('MP', 'after', STRING_REST)
    goalwire_side.graph.expect(EndpointKind.PUBLISHER, '/after')
    assert goalwire_side.graph.now(EndpointKind.PUBLISHER, '/chatter') == []
    wait_for(lambda: statistics(goalwire_side).get('token') == 5, 'five refused tokens')
    assert len(tokens) == 2


def test_a_request_that_is_being_worked_on_is_refused_the_second_time(
    goalwire_side: Side, peer: zenoh.Session, domain: str
) -> None:
    requests: Collector[Request] = Collector()
    goalwire_side.service('/add', requests)
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**/SS/**', direct(tokens), history=True)
    tokens.expect()
    first, second = Collector[zenoh.Reply](), Collector[zenoh.Reply]()
    peer.get(domain + ADD, direct(first), payload=b'once', attachment=beside(1))
    requests.expect()
    peer.get(domain + ADD, direct(second), payload=b'twice', attachment=beside(1))
    error = second.expect()[0].err
    assert error is not None
    assert b'worked on already' in error.payload.to_bytes()
    requests.items[0].reply(b'done')
    answer = first.expect()[0].ok
    assert answer is not None
    assert [request.sample.payload for request in requests.items] == [b'once']
    assert statistics(goalwire_side) == {'request': 1}


@pytest.mark.parametrize(
    ('payload', 'attachment', 'says'),
    [(b'x', None, 'there is none'), (b'x', b'short', '5 bytes'), (None, beside(1), 'no payload')],
    ids=['no attachment', 'a short attachment', 'no payload'],
)
def test_a_request_that_breaks_the_rules_is_told_why(
    goalwire_side: Side,
    peer: zenoh.Session,
    domain: str,
    payload: bytes | None,
    attachment: bytes | None,
    says: str,
) -> None:
    requests: Collector[Request] = Collector()
    goalwire_side.service('/add', requests)
    tokens: Collector[zenoh.Sample] = Collector()
    peer.liveliness().declare_subscriber(f'@ros2_lv/{domain}/**/SS/**', direct(tokens), history=True)
    tokens.expect()
    replies: Collector[zenoh.Reply] = Collector()
    peer.get(domain + ADD, direct(replies), payload=payload, attachment=attachment)
    error = replies.expect()[0].err
    assert error is not None
    assert says in error.payload.to_bytes().decode()
    assert requests.items == []


def test_a_peers_error_and_a_strangers_reply_end_a_request_without_one(
    goalwire_side: Side, peer: zenoh.Session, peer_node: PeerNode, domain: str
) -> None:
    def serve(query: zenoh.Query) -> None:
        query.reply_err(b'no')
        query.reply(domain + ADD, b'for another request', attachment=beside(99))
        query.reply(domain + ADD, b'without attachment')
        query.drop()  # type: ignore[no-untyped-call]

    peer.declare_queryable(domain + ADD, zenoh.handlers.Callback(serve, indirect=False), complete=True)
    peer_node.show('SS', 'add', ADD_REST)
    client = goalwire_side.client('/add')
    goalwire_side.graph.expect(EndpointKind.SERVICE, '/add')
    answers = Answers()
    answers.ask(client)
    answers.expect(replies=0)
    assert answers.reasons == ['no']
    assert statistics(goalwire_side) == {'reply': 2}
