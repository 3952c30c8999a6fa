"""Messages that several threads publish at once, as zenoh's advanced subscriber judges them.

Each subscriber of rmw_zenoh is an advanced one. It drops a message whose stamp is not newer than the last
that came from that session on that key.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Sequence
from itertools import pairwise

import pytest
import zenoh
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.wire import HASH, Side, topic_endpoint
from zenoh import ext

from goalwire.logging import LogRecord
from goalwire.records import replace
from goalwire.rules.qos import DurabilityPolicy, HistoryPolicy, QoS, ReliabilityPolicy
from goalwire.transport.contract import EndpointKind, PublisherPort
from goalwire.transport.zenoh.context import Turn, Turns, Waiting

KEY = f'/chatter/std_msgs::msg::dds_::String_/{HASH}'
THREADS, EACH = 4, 1000
ALL = QoS(history=HistoryPolicy.KEEP_ALL)
LASTING = QoS(
    depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.BEST_EFFORT
)


def publish_at_once(ports: Sequence[PublisherPort]) -> None:
    """Publish EACH messages on each port, a thread a port, all at the same time."""
    start = threading.Barrier(len(ports), timeout=PATIENCE)

    def run(port: PublisherPort) -> None:
        start.wait(PATIENCE)
        for _ in range(EACH):
            port.publish(b'x' * 100)

    threads = [threading.Thread(target=run, args=(port,)) for port in ports]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


@pytest.mark.parametrize('kind', ['one publisher', 'a publisher a thread', 'feedback', 'some with history'])
def test_an_advanced_subscriber_gets_all_that_several_threads_publish(
    goalwire_side: Side, peer: zenoh.Session, world: dict[str, str], kind: str
) -> None:
    domain = world['ROS_DOMAIN_ID']
    key = domain + KEY
    heard: Collector[zenoh.Sample] = Collector()
    judged: Collector[zenoh.Sample] = Collector()
    peer.declare_subscriber(key, zenoh.handlers.Callback(heard, indirect=False))
    ext.declare_advanced_subscriber(peer, key, zenoh.handlers.Callback(judged, indirect=False))
    ports: Sequence[PublisherPort]
    if kind == 'some with history':
        ports = [goalwire_side.publisher('/chatter', qos) for qos in (ALL, LASTING, ALL, LASTING)]
    elif kind == 'feedback':
        endpoint = topic_endpoint(EndpointKind.PUBLISHER, '/chatter', QoS(depth=10))
        ports = [goalwire_side.node.publisher(replace(endpoint, waits_for_room=True))] * THREADS
    else:
        number = 1 if kind == 'one publisher' else THREADS
        ports = [goalwire_side.publisher('/chatter', ALL) for _ in range(number)] * (THREADS // number)
    state, rest = f'@ros2_lv/{domain}/{peer.zid()}/0/1/MS/%/%/theirs', KEY.removeprefix('/chatter')
    token = peer.liveliness().declare_token(f'{state}/%chatter{rest}/::,10:,:,:,,')
    goalwire_side.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter')  # it was declared after the subscribers
    publish_at_once(ports)
    stamps = [sample.timestamp for sample in heard.expect(THREADS * EACH)]
    assert all(other > one for one, other in pairwise(stamps))  # type: ignore[operator]
    assert len(judged.expect(THREADS * EACH)) == THREADS * EACH
    token.undeclare()  # type: ignore[no-untyped-call]


def test_a_message_that_cannot_be_sent_holds_up_no_other(records: list[LogRecord]) -> None:
    turn, sent = Turn(), Collector[int]()

    def fail() -> None:
        raise MemoryError

    turn.post('a link', Waiting(turn, 1, fail), 10)
    turn.post('a link', Waiting(turn, 1, lambda: sent(1)), 10)
    sent.expect(1)
    turn.wait()
    assert ['MemoryError' in record.message for record in records] == [True]


def test_a_message_waits_for_those_of_its_own_link_alone() -> None:
    turn, sent, may_go_on = Turn(), Collector[int](), threading.Event()

    def stand_still() -> None:
        assert may_go_on.wait(PATIENCE)
        sent(1)

    turn.post('stuck', Waiting(turn, 1, stand_still), 10)
    turn.post('stuck', Waiting(turn, 1, lambda: sent(2)), 10)
    turn.post('free', Waiting(turn, 1, lambda: sent(3)), 10)
    assert sent.expect(1) == [3]
    assert turn.is_busy
    may_go_on.set()
    turn.wait()
    assert sent.items == [3, 1, 2]
    assert not turn.lanes


def test_where_no_thread_can_be_started_nothing_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    turn, sent = Turn(), Collector[int]()
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, 'start', refuse)
        with pytest.raises(RuntimeError, match='new thread'):
            turn.post('a link', Waiting(turn, 1, lambda: sent(1)), 10)
    assert not turn.is_busy
    turn.post('a link', Waiting(turn, 1, lambda: sent(2)), 10)
    assert sent.expect(1) == [2]


def test_a_turn_is_shared_by_key_and_forgotten_with_its_last_publisher() -> None:
    turns = Turns()
    first, other = turns.of('a'), turns.of('b')
    assert turns.of('a') is first
    assert other is not first
    del first, other
    gc.collect()
    assert not turns._of
