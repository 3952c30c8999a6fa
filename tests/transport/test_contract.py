"""Topics, lifetimes and errors: what every transport must do, whatever its wire.

Services and the graph are in test_contract_services.py and test_contract_graph.py.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable

import pytest
from helpers.collector import Collector
from helpers.isolation import fresh_domain
from helpers.processes import Program
from helpers.wire import OTHER_HASH, Answers, ContentPublisher, Side, numbers
from helpers.wires import DDS

from goalwire.errors import ClosedError
from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy
from goalwire.transport import registry
from goalwire.transport.contract import EndpointKind, NodeName, Request, Sample, Session, SessionOptions

PUBLISHER, SUBSCRIPTION = EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION
LASTING = QoS(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)

Samples = Collector[Sample]
Sides = tuple[Side, Side]


def payloads(samples: list[Sample]) -> list[bytes]:
    return [bytes(sample.payload) for sample in samples]


def connected(sides: Sides, deliver: Callable[[Sample], None], qos: QoS | None = None) -> ContentPublisher:
    """Return a publisher of the first side, known to reach a subscription of the second."""
    alpha, beta = sides
    publisher = alpha.publisher('/chatter', qos)
    beta.subscription('/chatter', deliver, qos)
    alpha.graph.expect(SUBSCRIPTION, '/chatter')
    return publisher


# -- publishing --------------------------------------------------------------------------------------------


def test_a_message_arrives_with_its_sequence_time_and_source(sides: Sides, transport_name: str) -> None:
    samples = Samples()
    publisher = connected(sides, samples)
    before = time.time_ns()
    publisher.publish(b'hello')
    (sample,) = samples.expect(1)
    (number,) = numbers(transport_name, [1])
    assert (bytes(sample.payload), sample.sequence, sample.gid) == (b'hello', number, publisher.gid)
    assert before <= sample.source_timestamp <= sample.received_timestamp <= time.time_ns()


def test_a_message_within_one_session_is_there_when_publishing_returns(
    sides: Sides, transport_name: str
) -> None:
    samples = Samples()
    alpha, _ = sides
    alpha.subscription('/chatter', samples)
    alpha.publisher('/chatter').publish(b'hello')
    assert payloads(samples.items) == [b'hello']
    if transport_name != DDS:  # there the session's thread may be faster
        assert samples.threads == [threading.get_ident()]


def test_a_subscription_that_ignores_its_own_session_hears_only_the_others(sides: Sides) -> None:
    alpha, beta = sides
    samples = Samples()
    alpha.subscription('/chatter', samples, ignore_local=True)
    own, other = alpha.publisher('/chatter'), beta.publisher('/chatter')
    beta.graph.expect(SUBSCRIPTION, '/chatter')
    own.publish(b'own')
    other.publish(b'other')
    assert payloads(samples.expect(1)) == [b'other']


def test_messages_of_one_publisher_arrive_in_order_and_counted(sides: Sides, transport_name: str) -> None:
    samples = Samples()
    publisher = connected(sides, samples, QoS(depth=1000))
    for number in range(500):
        publisher.publish(b'%d' % number)
    arrived = samples.expect(500)
    assert payloads(arrived) == [b'%d' % number for number in range(500)]
    assert [sample.sequence for sample in arrived] == numbers(transport_name, list(range(1, 501)))


@pytest.mark.differs_on(DDS, 'messages are not numbered')
def test_each_publisher_counts_for_itself(sides: Sides) -> None:
    samples = Samples()
    first = connected(sides, samples)
    second = sides[0].publisher('/chatter')
    first.publish(b'')
    first.publish(b'')
    second.publish(b'')
    assert {(sample.gid, sample.sequence) for sample in samples.expect(3)} == {
        (first.gid, 1),
        (first.gid, 2),
        (second.gid, 1),
    }


@pytest.mark.parametrize('size', [0, 1, 65_535, 65_536, 3_000_000])
def test_a_message_of_any_size_arrives_unchanged(sides: Sides, size: int) -> None:
    samples = Samples()
    publisher = connected(sides, samples)
    message = bytes(range(256)) * (size // 256 + 1)
    publisher.publish(message[:size])
    (sample,) = samples.expect(1)
    assert bytes(sample.payload) == message[:size]


def test_every_subscription_gets_every_message(sides: Sides) -> None:
    alpha, beta = sides
    event_queues = [Samples() for _ in range(3)]
    publisher = connected(sides, event_queues[0])
    beta.subscription('/chatter', event_queues[1])
    alpha.subscription('/chatter', event_queues[2])
    alpha.graph.expect(SUBSCRIPTION, '/chatter', 3)
    publisher.publish(b'hello')
    assert [payloads(event_queue.expect(1)) for event_queue in event_queues] == [[b'hello']] * 3


@pytest.mark.differs_on(DDS, 'types are compared by name, not by definition')
def test_a_publisher_of_another_definition_is_not_heard(sides: Sides) -> None:
    samples = Samples()
    publisher = connected(sides, samples)
    sides[0].publisher('/chatter', type_hash=OTHER_HASH).publish(b'other')
    publisher.publish(b'same')
    assert payloads(samples.expect(1)) == [b'same']


@pytest.mark.differs_on(DDS, 'endpoints with incompatible QoS exchange nothing')
def test_qos_that_disagrees_prevents_no_delivery(sides: Sides) -> None:
    alpha, beta = sides
    samples = Samples()
    publisher = alpha.publisher('/chatter', QoS(reliability=ReliabilityPolicy.BEST_EFFORT))
    beta.subscription('/chatter', samples, LASTING)
    alpha.graph.expect(SUBSCRIPTION, '/chatter')
    publisher.publish(b'hello')
    assert payloads(samples.expect(1)) == [b'hello']


# -- history -----------------------------------------------------------------------------------------------


def published(side: Side, qos: QoS, number: int) -> ContentPublisher:
    """Return a publisher that has published '0', '1', … to nobody."""
    publisher = side.publisher('/map', qos)
    for index in range(number):
        publisher.publish(b'%d' % index)
    return publisher


def test_a_late_subscription_gets_the_last_messages_then_the_new_ones(
    sides: Sides, transport_name: str
) -> None:
    alpha, beta = sides
    samples = Samples()
    publisher = published(alpha, LASTING, 5)
    beta.graph.expect(PUBLISHER, '/map')
    beta.subscription('/map', samples, LASTING)
    assert payloads(samples.expect(3)) == [b'2', b'3', b'4']
    alpha.graph.expect(SUBSCRIPTION, '/map')
    publisher.publish(b'new')
    arrived = samples.expect(4)
    assert payloads(arrived) == [b'2', b'3', b'4', b'new']
    assert [sample.sequence for sample in arrived] == numbers(transport_name, [3, 4, 5, 6])


def test_a_late_subscription_gets_no_more_history_than_its_own_depth(sides: Sides) -> None:
    alpha, beta = sides
    samples = Samples()
    publisher = published(alpha, LASTING, 3)
    beta.graph.expect(PUBLISHER, '/map')
    beta.subscription('/map', samples, QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    assert payloads(samples.expect(1)) == [b'2']
    alpha.graph.expect(SUBSCRIPTION, '/map')
    publisher.publish(b'new')
    assert payloads(samples.expect(2)) == [b'2', b'new']


def test_a_volatile_subscription_gets_no_history(sides: Sides) -> None:
    alpha, beta = sides
    samples = Samples()
    publisher = published(alpha, LASTING, 3)
    beta.graph.expect(PUBLISHER, '/map')
    beta.subscription('/map', samples, QoS())
    alpha.graph.expect(SUBSCRIPTION, '/map')
    publisher.publish(b'new')
    assert payloads(samples.expect(1)) == [b'new']


@pytest.mark.differs_on(DDS, 'endpoints with incompatible QoS exchange nothing')
def test_a_volatile_publisher_keeps_no_history(sides: Sides) -> None:
    alpha, beta = sides
    samples = Samples()
    publisher = published(alpha, QoS(), 3)
    beta.graph.expect(PUBLISHER, '/map')
    beta.subscription('/map', samples, LASTING)
    alpha.graph.expect(SUBSCRIPTION, '/map')
    publisher.publish(b'new')
    assert payloads(samples.expect(1)) == [b'new']


def test_history_within_one_session_works_too(sides: Sides) -> None:
    alpha, _ = sides
    samples = Samples()
    publisher = published(alpha, LASTING, 4)
    alpha.subscription('/map', samples, LASTING)
    assert payloads(samples.expect(3)) == [b'1', b'2', b'3']
    publisher.publish(b'new')
    assert payloads(samples.expect(4)) == [b'1', b'2', b'3', b'new']


# -- the end -----------------------------------------------------------------------------------------------


def test_nothing_is_lost_where_many_threads_publish_with_history(sides: Sides, transport_name: str) -> None:
    came: Collector[Sample] = Collector()
    qos = QoS(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = connected(sides, came, qos)

    def talk(who: int) -> None:
        for number in range(50):
            publisher.publish(f'{who} {number}'.encode())

    threads = [threading.Thread(target=talk, args=(who,)) for who in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    samples = came.expect(200)
    assert [sample.sequence for sample in samples] == numbers(transport_name, list(range(1, 201)))
    assert sorted(payloads(samples)) == sorted(f'{who} {n}'.encode() for who in range(4) for n in range(50))


def test_a_closed_subscription_gets_nothing_more(sides: Sides) -> None:
    _, beta = sides
    kept, closed = Samples(), Samples()
    publisher = connected(sides, kept)
    port = beta.subscription('/chatter', closed)
    port.close()
    publisher.publish(b'hello')
    kept.expect(1)
    assert closed.items == []


def test_a_subscription_may_be_closed_while_messages_pour_in(sides: Sides) -> None:
    alpha, beta = sides
    samples = Samples()
    publisher = alpha.publisher('/chatter')
    port = beta.subscription('/chatter', samples)
    alpha.graph.expect(SUBSCRIPTION, '/chatter')
    stop = threading.Event()

    def pour() -> None:
        while not stop.is_set():
            publisher.publish(b'drop')

    thread = threading.Thread(target=pour)
    thread.start()
    try:
        samples.expect(10)
        port.close()
        alpha.graph.expect(SUBSCRIPTION, '/chatter', 0)
    finally:
        stop.set()
        thread.join()
    # The other thread may still hand over what it had read before. What is published now must not arrive.
    fence = Samples()
    beta.subscription('/fence', fence)
    alpha.graph.expect(SUBSCRIPTION, '/fence')
    publisher.publish(b'late')
    alpha.publisher('/fence').publish(b'')
    fence.expect(1)
    assert b'late' not in {sample.payload for sample in samples.items}


def test_a_session_may_be_closed_while_another_thread_publishes(sides: Sides) -> None:
    alpha, _ = sides
    samples = Samples()
    publisher = connected(sides, samples)
    refused = Collector[ClosedError]()
    stop = threading.Event()

    def pour() -> None:
        try:
            while not stop.is_set():
                publisher.publish(b'drop')
        except ClosedError as error:
            refused(error)

    thread = threading.Thread(target=pour)
    thread.start()
    try:
        samples.expect(10)
        alpha.session.close()
        refused.expect(1)
    finally:
        stop.set()
        thread.join()


def test_closing_twice_is_harmless(sides: Sides) -> None:
    alpha, _ = sides
    ports = [
        alpha.publisher('/chatter'),
        alpha.subscription('/chatter', Samples()),
        alpha.service('/add', Collector[Request]()),
        alpha.client('/add'),
        alpha.node,
    ]
    for port in [*ports, *ports, *reversed(ports)]:
        port.close()
    alpha.session.close()
    alpha.session.close()
    for port in ports:
        port.close()


def close_port(side: Side, publisher: ContentPublisher) -> None:
    publisher.close()


def close_node(side: Side, publisher: ContentPublisher) -> None:
    side.node.close()


def close_session(side: Side, publisher: ContentPublisher) -> None:
    side.session.close()


@pytest.mark.parametrize('close', [close_port, close_node, close_session])
def test_publishing_after_the_end_is_refused_by_name(
    sides: Sides, close: Callable[[Side, ContentPublisher], None]
) -> None:
    publisher = sides[0].publisher('/chatter')
    close(sides[0], publisher)
    with pytest.raises(ClosedError, match='/chatter'):
        publisher.publish(b'late')


def test_requesting_after_the_end_is_refused_by_name(sides: Sides) -> None:
    client = sides[0].client('/add')
    client.close()
    with pytest.raises(ClosedError, match='/add'):
        Answers().ask(client)


@pytest.mark.parametrize(
    'declare',
    [
        lambda side: side.publisher('/chatter'),
        lambda side: side.subscription('/chatter', Samples()),
        lambda side: side.service('/add', Collector[Request]()),
        lambda side: side.client('/add'),
    ],
)
def test_a_closed_node_declares_nothing(sides: Sides, declare: Callable[[Side], object]) -> None:
    sides[0].node.close()
    with pytest.raises(ClosedError, match='/alpha'):
        declare(sides[0])


@pytest.mark.parametrize(
    'use',
    [lambda side: side.session.node(NodeName('late')), lambda side: side.session.watch_graph(side.graph)],
)
def test_a_closed_session_is_of_no_use(sides: Sides, use: Callable[[Side], object]) -> None:
    sides[0].session.close()
    with pytest.raises(ClosedError):
        use(sides[0])


def test_the_rest_goes_on_when_one_session_closes(sides: Sides, open_session: Callable[[], Session]) -> None:
    samples = Samples()
    publisher = connected(sides, samples)
    third = Side(open_session(), 'gamma')
    third.subscription('/chatter', Samples())
    sides[0].graph.expect(SUBSCRIPTION, '/chatter', 2)
    third.session.close()
    sides[0].graph.expect(SUBSCRIPTION, '/chatter', 1)
    publisher.publish(b'still here')
    assert payloads(samples.expect(1)) == [b'still here']


def test_domains_do_not_hear_each_other(sides: Sides, transport_name: str) -> None:
    samples = Samples()
    publisher = connected(sides, samples)
    elsewhere = registry.get(transport_name).open(SessionOptions(domain_id=fresh_domain()))
    try:
        stranger = Side(elsewhere, 'stranger')
        stranger.publisher('/chatter').publish(b'elsewhere')
        publisher.publish(b'here')
        assert payloads(samples.expect(1)) == [b'here']
        assert [entity.node.name for entity in stranger.graph.now(EndpointKind.NODE)] == ['stranger']
    finally:
        elsewhere.close()


FORKING = """
    import os, sys
    from goalwire.errors import ForkedError
    from goalwire.rules.qos import QoS
    from goalwire.transport import registry
    from goalwire.transport.contract import Endpoint, EndpointKind, NodeName, SessionOptions

    session = registry.get().open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
    node = session.node(NodeName('parent'))
    publisher = node.publisher(Endpoint(EndpointKind.PUBLISHER, '/chatter', 'a/msg/B', 'RIHS01_00', QoS()))

    def refused(use):
        try:
            use()
        except ForkedError as error:
            return 'fork' in str(error)
        return False

    child = os.fork()
    if child == 0:
        answers = [
            refused(lambda: publisher.publish(b'')),
            refused(lambda: session.node(NodeName('child'))),
            refused(lambda: node.client(Endpoint(EndpointKind.CLIENT, '/c', 'a/srv/B', 'RIHS01_00', QoS()))),
        ]
        publisher.close()
        session.close()
        os._exit(0 if all(answers) else 1)
    print('child', os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    publisher.publish(b'\\0\\1\\0\\0the parent goes on')
    session.close()
    print('parent done')
"""


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system has no fork')
def test_a_session_opened_before_a_fork_refuses_to_work_in_the_child(isolated: dict[str, str]) -> None:
    # Python itself warns of a fork beside threads from 3.12 on; that warning is not what is tested.
    with Program(FORKING, env=isolated) as program:
        output = program.succeed()
    assert 'child 0' in output
    assert 'parent done' in output
