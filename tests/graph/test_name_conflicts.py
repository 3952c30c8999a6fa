"""The mismatches that the graph finds between peers."""

from __future__ import annotations

from itertools import count

from goalwire.graph.graph import Graph
from goalwire.graph.name_conflicts import Mismatch, Reason
from goalwire.records import replace
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName

PUBLISHER, SUBSCRIPTION = EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION
SERVICE, CLIENT = EndpointKind.SERVICE, EndpointKind.CLIENT
OLD, NEW = f'RIHS01_{"0" * 64}', f'RIHS01_{"1" * 64}'
POSE = 'geometry_msgs/msg/Pose'

_numbers = count(1)


def endpoint(
    node: str, kind: EndpointKind, name: str, *, type_name: str = POSE, type_hash: str = OLD
) -> GraphEntity:
    number = next(_numbers)
    return GraphEntity(
        kind,
        f'session{number}',
        0,
        NodeName(node),
        name,
        type_name,
        type_hash,
        gid=number.to_bytes(16, 'little'),
    )


def found_in(*entities: GraphEntity, session: str | None = None) -> list[Mismatch]:
    graph = Graph(session)
    told: list[Mismatch] = []
    graph.on_mismatch(told.append)
    for entity in entities:
        graph.appeared(entity)
    return told


def test_another_definition_of_the_same_type_is_reported_naming_both_nodes() -> None:
    talker = endpoint('talker', PUBLISHER, '/pose', type_hash=OLD)
    listener = endpoint('listener', SUBSCRIPTION, '/pose', type_hash=NEW)
    (mismatch,) = found_in(talker, listener)
    assert mismatch == Mismatch(Reason.DEFINITION, '/pose', talker, listener)
    for part in ('/talker', '/listener', '/pose', POSE, OLD, NEW):
        assert part in str(mismatch)


def test_clients_and_servers_of_another_definition_are_reported_too() -> None:
    server = endpoint('server', SERVICE, '/add', type_hash=OLD)
    client = endpoint('client', CLIENT, '/add', type_hash=NEW)
    assert [mismatch.reason for mismatch in found_in(client, server)] == [Reason.DEFINITION]


def test_two_publishers_never_disturb_each_other() -> None:
    first = endpoint('first', PUBLISHER, '/pose', type_hash=OLD)
    assert found_in(first, endpoint('second', PUBLISHER, '/pose', type_hash=NEW)) == []


def test_another_type_under_one_name_is_reported_naming_both_types_and_nodes() -> None:
    talker = endpoint('talker', PUBLISHER, '/pose', type_hash=OLD)
    listener = endpoint('l', SUBSCRIPTION, '/pose', type_name='a/msg/B', type_hash=NEW)
    (mismatch,) = found_in(talker, listener)
    assert mismatch == Mismatch(Reason.TYPE, '/pose', talker, listener)
    assert str(mismatch) == (
        "Incompatible type on topic '/pose', no messages will be sent to it: publisher in node '/talker' has "
        "the type geometry_msgs/msg/Pose and subscription in node '/l' has the type a/msg/B; give both the "
        'same type, or give one of them another name'
    )


def test_another_type_of_a_service_is_reported_and_of_an_action_once() -> None:
    server, client = (
        endpoint('server', SERVICE, '/add', type_name='a/srv/A'),
        endpoint('client', CLIENT, '/add', type_name='a/srv/B'),
    )
    (mismatch,) = found_in(client, server)
    assert str(mismatch).startswith(
        "Incompatible types of '/add', no requests pass: client in node '/client' has the type a/srv/B and "
        "service in node '/server' has the type a/srv/A; "
    )
    parts = [
        endpoint(node, kind, f'/walk/_action/{part}', type_name=f'a/action/{name}_{type_}')
        for node, kinds, name in (
            ('server', (SERVICE, PUBLISHER), 'Walk'),
            ('client', (CLIENT, SUBSCRIPTION), 'Run'),
        )
        for part, type_, kind in (
            ('send_goal', 'SendGoal', kinds[0]),
            ('get_result', 'GetResult', kinds[0]),
            ('feedback', 'FeedbackMessage', kinds[1]),
        )
    ]
    (told,) = found_in(*parts)
    assert (told.reason, told.name) == (Reason.TYPE, '/walk')
    assert "service in node '/server' has the type a/action/Walk and client" in str(told)


def test_a_type_that_is_not_told_is_no_other() -> None:
    talker = endpoint('talker', PUBLISHER, '/pose', type_name='')
    assert found_in(talker, endpoint('listener', SUBSCRIPTION, '/pose')) == []


def test_peers_that_agree_are_not_reported() -> None:
    assert found_in(endpoint('talker', PUBLISHER, '/pose'), endpoint('listener', SUBSCRIPTION, '/pose')) == []


def test_two_servers_of_one_name_are_reported_naming_both_nodes() -> None:
    first, second = endpoint('first', SERVICE, '/add'), endpoint('second', SERVICE, '/add')
    (mismatch,) = found_in(first, second)
    assert mismatch == Mismatch(Reason.TWO_SERVERS, '/add', first, second)
    for part in ('/first', '/second', '/add'):
        assert part in str(mismatch)


def test_two_servers_of_one_action_are_reported_once_by_the_action_name() -> None:
    parts = ('send_goal', 'cancel_goal', 'get_result')
    servers = [
        endpoint(node, SERVICE, f'/walk/_action/{part}', type_name=part)
        for node in ('one', 'two')
        for part in parts
    ]
    assert [(mismatch.reason, mismatch.name) for mismatch in found_in(*servers)] == [
        (Reason.TWO_SERVERS, '/walk')
    ]


def test_two_nodes_of_one_name_are_reported_once_however_many_services_they_share() -> None:
    servers = [endpoint('arm', SERVICE, f'/arm/{name}') for name in ('get', 'set', 'get', 'set')]
    (mismatch,) = found_in(*servers)
    assert (mismatch.reason, mismatch.name) == (Reason.TWO_NODES, '/arm')
    assert "two nodes have the name '/arm'" in str(mismatch)


def test_one_node_that_serves_a_name_twice_is_two_servers() -> None:
    first = endpoint('arm', SERVICE, '/add')
    again = replace(first, gid=b'another')
    assert [each.reason for each in found_in(first, again)] == [Reason.TWO_SERVERS]


def test_a_peer_that_comes_again_is_not_reported_again() -> None:
    graph = Graph()
    told: list[Mismatch] = []
    graph.on_mismatch(told.append)
    graph.appeared(endpoint('talker', PUBLISHER, '/pose', type_hash=OLD))
    listener = endpoint('listener', SUBSCRIPTION, '/pose', type_hash=NEW)
    graph.appeared(listener)
    graph.vanished(listener)
    graph.appeared(replace(listener, session='started anew', gid=b'another'))
    assert len(told) == 1


def test_with_a_session_of_its_own_a_graph_reports_what_concerns_that_alone() -> None:
    ours, theirs = endpoint('ours', SERVICE, '/add'), endpoint('theirs', SERVICE, '/add')
    stranger = endpoint('stranger', SERVICE, '/add')
    assert found_in(theirs, stranger, ours, session=ours.session) == [
        Mismatch(Reason.TWO_SERVERS, '/add', theirs, ours),
        Mismatch(Reason.TWO_SERVERS, '/add', stranger, ours),
    ]


def test_a_mismatch_of_others_hides_none_of_ours_between_nodes_of_the_same_names() -> None:
    theirs = [endpoint('a', SERVICE, '/add'), endpoint('b', SERVICE, '/add')]
    ours = endpoint('b', SERVICE, '/add')
    found = found_in(*theirs, ours, session=ours.session)
    assert Mismatch(Reason.TWO_SERVERS, '/add', theirs[0], ours) in found
