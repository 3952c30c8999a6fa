"""Cases of DDS alone: peers without ROS 2, malformed messages, events, the end of a reply's client."""

from __future__ import annotations

from collections.abc import Iterator
from ctypes import c_uint64

import pytest
import rclpy
from helpers.collector import Collector
from helpers.spinning import Spinner, wait_until
from helpers.stranger import Stranger
from helpers.wire import ADD, HASH, OTHER_HASH, STRING, Answers, Side, message, topic_endpoint
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

from goalwire.errors import LocalError, TransportError
from goalwire.rules.qos import DurabilityPolicy, LivelinessPolicy, QoS
from goalwire.rules.qos_events import (
    EventStatus,
    LivelinessChanged,
    LivelinessLost,
    Matched,
    OfferedDeadlineMissed,
    PublisherEvent,
    RequestedDeadlineMissed,
    SubscriptionEvent,
)
from goalwire.transport.contract import Endpoint, EndpointKind, Request, Sample, SessionOptions
from goalwire.transport.dds import TRANSPORT
from goalwire.transport.dds.cyclone.abi import BuiltinEndpoint
from goalwire.transport.dds.cyclone.qos import read_user_data
from goalwire.transport.dds.cyclone.services import CycloneClient, CycloneService
from goalwire.transport.dds.cyclone.session import CycloneSession
from goalwire.transport.dds.cyclone.wire import Reader, Writer
from goalwire.transport.dds.description import (
    DISCOVERY_TOPIC,
    DISCOVERY_TYPE,
    Role,
    dds_topic,
    dds_type,
    decode_endpoint,
)
from goalwire.transport.dds.discovery_state import UNKNOWN_NAME
from goalwire.transport.dds.service_header import Header, unwrap, wrap

Sides = tuple[Side, Side]


@pytest.fixture
def stranger(dds_sides: Sides, alone: dict[str, str]) -> Iterator[Stranger]:
    stranger = Stranger(int(alone['ROS_DOMAIN_ID']))
    yield stranger
    stranger.close()


def rejects(side: Side, kind: str) -> int:
    session = side.session
    assert isinstance(session, CycloneSession)
    return session.statistics().get(kind, 0)


def test_an_endpoint_without_ros_2_is_nobodys_and_heard(dds_sides: Sides, stranger: Stranger) -> None:
    alpha, _ = dds_sides
    came: Collector[Sample] = Collector()
    alpha.subscription('/chatter', came)
    writer = stranger.writer('rt/chatter', 'std_msgs::msg::dds_::String_')
    (seen,) = alpha.graph.expect(EndpointKind.PUBLISHER, '/chatter')
    assert (seen.node.name, seen.type_hash, seen.gid) == (UNKNOWN_NAME, '', writer.guid)
    assert writer.write(message(b'hello')) == 0
    assert came.expect(1)[0].gid == writer.guid


def test_a_reader_of_no_node_is_counted_when_its_match_is_told(stranger: Stranger) -> None:
    counts: Collector[tuple[int, int]] = Collector()

    def matched(info: Matched) -> None:
        counts((info.current_count, publisher.get_subscription_count()))

    context = Context()
    with rclpy.init(context=context):
        node = Node('counting', context=context)
        publisher = node.create_publisher(
            String, 'chatter', 1, event_callbacks=PublisherEventCallbacks(matched=matched)
        )
        with SingleThreadedExecutor(context=context) as executor, Spinner(executor, node):
            stranger.writer(DISCOVERY_TOPIC, DISCOVERY_TYPE)  # so the graph waits for it to name a node
            reader = stranger.reader('rt/chatter', 'std_msgs::msg::dds_::String_')
            assert counts.expect(1) == [(1, 1)]
            reader.delete()
            assert counts.expect(2)[1] == (0, 0)
            stranger.reader('rt/chatter', 'std_msgs::msg::dds_::String_')
            wait_until(context, lambda: publisher.get_subscription_count() == 1)


@pytest.mark.parametrize('payload', [b'\0\1\0\0\0', b'\0\1\0\0' + bytes(16)])
def test_a_request_without_a_header_is_rejected_and_counted(
    dds_sides: Sides, stranger: Stranger, payload: bytes
) -> None:
    alpha, _ = dds_sides
    asked: Collector[Request] = Collector()
    alpha.service('/add', asked)
    writer = stranger.writer(dds_topic(Role.REQUEST, '/add'), dds_type(Role.REQUEST, ADD))
    alpha.graph.expect(EndpointKind.CLIENT, '/add')
    assert writer.write(payload) == 0
    fence = Answers()
    client = alpha.client('/add')
    fence.ask(client, b'sound')
    assert asked.expect(1)[0].sample.gid == client.gid
    assert rejects(alpha, 'request') == 1


def test_a_reply_without_a_header_is_rejected_and_counted(dds_sides: Sides, stranger: Stranger) -> None:
    alpha, beta = dds_sides
    client, answers = alpha.client('/add'), Answers()
    writer = stranger.writer(dds_topic(Role.REPLY, '/add'), dds_type(Role.REPLY, ADD))
    assert writer.write(b'\0\1\0\0' + bytes(16)) == 0
    beta.service('/add', lambda request: request.reply(b'sound'))
    alpha.expect_server(client, '/add')
    answers.ask(client)
    answers.expect(replies=1)
    assert rejects(alpha, 'reply') == 1


def test_an_announcement_that_cannot_be_read_is_rejected_and_the_next_one_read(
    dds_sides: Sides, stranger: Stranger
) -> None:
    alpha, beta = dds_sides
    writer = stranger.writer(
        DISCOVERY_TOPIC, DISCOVERY_TYPE, QoS(durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    assert writer.write(b'\0\1\0\0' + b'\xff' * 40) == 0
    beta.publisher('/after')
    alpha.graph.expect(EndpointKind.PUBLISHER, '/after')
    alpha.graph.wait_for(lambda: rejects(alpha, 'ros_discovery_info') == 1)


def test_bytes_that_are_no_message_are_refused_by_name(dds_sides: Sides) -> None:
    port = dds_sides[0].publisher('/chatter').port
    for payload in (b'', b'\0\1\0\0', b'hello world!'):
        with pytest.raises(LocalError, match=f"topic 'rt/chatter': {len(payload)} bytes"):
            port.publish(payload)


def test_a_domain_beyond_the_ports_is_refused(alone: dict[str, str]) -> None:
    with pytest.raises(TransportError, match=r'domain 233 has no ports .*to at most 232'):
        TRANSPORT.open(SessionOptions(233))


def test_a_configuration_that_cyclone_refuses_is_pointed_out(
    alone: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv('CYCLONEDDS_URI', '<CycloneDDS><Domain><NoSuchThing/></Domain></CycloneDDS>')
    with pytest.raises(TransportError, match=r'refused the configuration .* check CYCLONEDDS_URI'):
        TRANSPORT.open(SessionOptions(int(alone['ROS_DOMAIN_ID'])))
    assert 'NoSuchThing' in capfd.readouterr().err


# -- events ------------------------------------------------------------------------------------------------


def test_missed_deadlines_are_told_on_both_sides(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    offered: Collector[EventStatus] = Collector()
    requested: Collector[EventStatus] = Collector()
    qos = QoS(deadline_ns=20_000_000)
    publisher = alpha.publisher('/chatter', qos)
    subscription = beta.subscription('/chatter', lambda _: None, qos)
    assert publisher.port.watch_event(PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED, offered)
    assert subscription.watch_event(SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED, requested)
    alpha.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter')
    publisher.publish(b'the only one')
    assert isinstance(offered.expect(2)[-1], OfferedDeadlineMissed)
    assert isinstance(requested.expect(2)[-1], RequestedDeadlineMissed)


def test_a_publisher_that_does_not_assert_its_liveliness_loses_it_and_may_regain_it(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    lost: Collector[EventStatus] = Collector()
    changed: Collector[EventStatus] = Collector()
    qos = QoS(liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, lease_ns=100_000_000)
    publisher = alpha.publisher('/chatter', qos)
    subscription = beta.subscription('/chatter', lambda _: None, qos)
    assert publisher.port.watch_event(PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST, lost)
    assert subscription.watch_event(SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED, changed)
    changed.wait_for(lambda seen: LivelinessChanged(0, 0, 1, 0) in seen)
    assert lost.expect(1)[-1] == LivelinessLost(1)
    publisher.port.assert_liveliness()
    publisher.publish(b'here again')
    changed.wait_for(lambda seen: seen[-1] == LivelinessChanged(1, 0, 0, 0))


def test_a_match_is_told_to_who_comes_after_it_too(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    matched: Collector[EventStatus] = Collector()
    publisher = alpha.publisher('/chatter')
    port = beta.subscription('/chatter', lambda _: None)
    alpha.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter')
    assert publisher.port.watch_event(PublisherEvent.RCL_PUBLISHER_MATCHED, matched)
    assert matched.expect(1)[-1] == Matched(1, 0, 1, 0)
    port.close()
    assert matched.expect(2)[-1] == Matched(1, 0, 0, 0)


def test_feedback_is_announced_with_the_depth_of_its_profile(dds_sides: Sides) -> None:
    name = '/fib/_action/feedback'
    of = STRING, HASH, QoS(depth=10)
    dds_sides[0].node.publisher(Endpoint(EndpointKind.PUBLISHER, name, *of, waits_for_room=True))
    seen = dds_sides[1].graph.expect(EndpointKind.PUBLISHER, name)
    assert [each.qos.depth for each in seen] == [10]


def test_another_type_of_the_same_name_is_left_to_the_graph(dds_sides: Sides) -> None:
    port = dds_sides[0].publisher('/chatter').port
    assert not port.watch_event(PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE, lambda _: None)


def test_acknowledgements_may_be_waited_for(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    came: Collector[Sample] = Collector()
    publisher = alpha.publisher('/chatter')
    beta.subscription('/chatter', came)
    alpha.graph.expect(EndpointKind.SUBSCRIPTION, '/chatter')
    publisher.publish(b'hello')
    assert publisher.port.wait_for_acknowledgements(10_000_000_000)
    assert len(came.items) == 1


# -- services ----------------------------------------------------------------------------------------------


def test_a_client_reaches_a_server_only_while_there_is_one(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    client = alpha.client('/add')
    assert not client.reaches_server()
    server = beta.service('/add', lambda request: request.reply(b''))
    alpha.expect_server(client, '/add')
    server.close()
    alpha.graph.wait_for(lambda: not client.reaches_server())


def test_a_reply_to_a_client_that_has_gone_is_no_fault(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    asked: Collector[Request] = Collector()
    beta.service('/add', asked)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    Answers().ask(client)
    (request,) = asked.expect(1)
    client.close()
    request.reply(b'nobody is there to hear it')
    assert rejects(beta, 'reply') == 0


def test_many_requests_at_once_are_all_answered(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    asked: Collector[Request] = Collector()
    beta.service('/add', asked)
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    answers = Answers()
    for number in range(500):
        answers.ask(client, b'%d' % number)
    for request in asked.expect(500):
        request.reply(bytes(request.sample.payload))
    assert len(answers.expect(replies=500, ends=500)) == 500


def test_a_type_hash_is_told_and_read(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    alpha.node.publisher(topic_endpoint(EndpointKind.PUBLISHER, '/chatter'))
    assert beta.graph.expect(EndpointKind.PUBLISHER, '/chatter')[0].type_hash == HASH


def hash_opposite(end: Reader | Writer) -> str:
    """Return the hash that the endpoint announces which `end` is matched with."""
    library, handles = end.library, (c_uint64 * 1)()
    kind = 'subscription' if isinstance(end, Writer) else 'publication'
    assert getattr(library, f'dds_get_matched_{kind}s')(end.handle, handles, 1) == 1
    address = getattr(library, f'dds_get_matched_{kind}_data')(end.handle, handles[0])
    try:
        qos = BuiltinEndpoint.from_address(address).qos
        return decode_endpoint(read_user_data(library, qos)).type_hash
    finally:
        library.dds_builtintopic_free_endpoint(address)


def test_each_end_of_a_service_announces_the_hash_of_what_it_carries(dds_sides: Sides) -> None:
    """The graph shows neither: they say less than the service's own, which is not on this wire."""
    alpha, beta = dds_sides
    offered, used = (
        Endpoint(kind, '/add', ADD, '', QoS(), part_hashes=lambda: (HASH, OTHER_HASH))
        for kind in (EndpointKind.SERVICE, EndpointKind.CLIENT)
    )
    server, client = beta.node.service(offered, lambda _: None), alpha.node.client(used)
    assert isinstance(server, CycloneService)
    assert isinstance(client, CycloneClient)
    alpha.graph.wait_for(client.reaches_server)
    announced = [hash_opposite(end) for end in (server.reader, client._writer, server._writer, client.reader)]
    assert announced == [HASH, HASH, OTHER_HASH, OTHER_HASH]
    assert {seen.type_hash for seen in alpha.graph.expect(EndpointKind.SERVICE, '/add')} == {''}


def test_a_client_that_does_not_know_refusals_is_sent_none(dds_sides: Sides, stranger: Stranger) -> None:
    """One of stock ROS 2: its call ends when the server goes, as there."""
    asked: Collector[Request] = Collector()
    dds_sides[0].service('/add', asked)
    writer = stranger.writer(dds_topic(Role.REQUEST, '/add'), dds_type(Role.REQUEST, ADD))
    reader = stranger.reader(dds_topic(Role.REPLY, '/add'), dds_type(Role.REPLY, ADD))
    for sequence in (1, 2):
        assert writer.write(wrap(Header(writer.instance, sequence), message(b'request'))) == 0
    first, second = asked.expect(2)
    first.cancel('no time')
    second.reply(b'an answer')
    _, taken = reader.take()
    assert [unwrap(each.payload)[0] for each in taken] == [Header(writer.instance, 2)]


def test_nothing_is_kept_of_a_call_that_one_server_refuses_and_another_answers(dds_sides: Sides) -> None:
    alpha, beta = dds_sides
    refusing: Collector[Request] = Collector()
    answering: Collector[Request] = Collector()
    alpha.service('/add', refusing)
    beta.service('/add', answering)
    client, answers = alpha.client('/add').port, Answers()
    assert isinstance(client, CycloneClient)
    alpha.graph.wait_for(lambda: len(client._requested) == len(client._answering) == 2)
    sequence = client.request(message(b'request'), answers.replies, answers.on_end)
    refusing.expect(1)[0].cancel('no time')
    assert client._refusals == {sequence: 'no time'}
    answering.expect(1)[0].reply(message(b'an answer'))
    answers.expect(replies=1)
    assert not client._calls
    assert not client._refusals


def test_a_refusal_bears_the_id_of_the_client_that_it_is_for(dds_sides: Sides, stranger: Stranger) -> None:
    """So a client of stock ROS 2, which gets it too, drops it."""
    alpha, beta = dds_sides
    reader = stranger.reader(dds_topic(Role.REPLY, '/add'), dds_type(Role.REPLY, ADD))
    beta.service('/add', lambda request: request.cancel('no time'))
    client, answers = alpha.client('/add'), Answers()
    alpha.expect_server(client, '/add')
    answers.ask(client)
    answers.expect(replies=0)
    assert answers.reasons == ['no time']
    _, taken = reader.take()
    assert isinstance(client.port, CycloneClient)
    assert [unwrap(each.payload)[0] for each in taken] == [Header(client.port._writer.instance, -1)]
