"""The graph: what discovery showed, asked in every way."""

from __future__ import annotations

from itertools import count
from threading import Thread
from time import thread_time

import pytest

from goalwire.graph.graph import Graph
from goalwire.logging import LogRecord
from goalwire.records import replace
from goalwire.rules.qos import INFINITE_NS, DurabilityPolicy, QoS, ReliabilityPolicy
from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, NodeName

PUBLISHER, SUBSCRIPTION = EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION
SERVICE, CLIENT = EndpointKind.SERVICE, EndpointKind.CLIENT
STRING = 'std_msgs/msg/String'
ADD = 'example_interfaces/srv/AddTwoInts'

_numbers = count(1)


def node(name: str, namespace: str = '/', session: str = 'a1') -> GraphEntity:
    return GraphEntity(EndpointKind.NODE, session, next(_numbers), NodeName(name, namespace))


def endpoint(
    owner: GraphEntity, kind: EndpointKind, name: str, type_name: str, qos: QoS | None = None
) -> GraphEntity:
    gid = next(_numbers).to_bytes(16, 'little')
    return replace(owner, kind=kind, name=name, type_name=type_name, qos=qos or QoS(), gid=gid)


def graph_of(*entities: GraphEntity, enforces_qos: bool = False) -> Graph:
    graph = Graph(enforces_qos=enforces_qos)
    for entity in entities:
        graph.appeared(entity)
    return graph


def test_two_nodes_of_one_name_are_two_entries() -> None:
    first, second = node('twin'), node('twin')
    assert graph_of(first, second).nodes() == [first, second]


def test_a_node_name_exists_until_its_last_bearer_has_gone() -> None:
    first, second = node('twin', '/ns'), node('twin', '/ns')
    graph = graph_of(first, second)
    graph.vanished(first)
    assert graph.node_exists('twin', '/ns')
    graph.vanished(second)
    assert not graph.node_exists('twin', '/ns')


def test_a_node_is_looked_up_in_its_own_namespace_only() -> None:
    assert not graph_of(node('arm', '/left')).node_exists('arm')


def test_adding_the_same_twice_changes_nothing() -> None:
    talker = node('talker')
    chatter = endpoint(talker, PUBLISHER, '/chatter', STRING)
    graph = graph_of(talker, chatter)
    calls: list[int] = []
    graph.on_change(lambda: calls.append(1))
    graph.appeared(talker)
    graph.appeared(chatter)
    assert (graph.nodes(), graph.entities(PUBLISHER, '/chatter'), calls) == ([talker], [chatter], [])


def test_an_endpoint_makes_its_node_known_and_takes_it_along() -> None:
    ghost = node('ghost')
    chatter = endpoint(ghost, PUBLISHER, '/chatter', STRING)
    graph = graph_of(chatter)
    assert graph.node_exists('ghost')
    graph.vanished(chatter)
    assert not graph.node_exists('ghost')


def test_a_declared_node_stays_without_endpoints() -> None:
    talker = node('talker')
    chatter = endpoint(talker, PUBLISHER, '/chatter', STRING)
    graph = graph_of(chatter, talker)
    graph.vanished(chatter)
    assert graph.nodes() == [talker]


def test_a_node_that_goes_takes_its_endpoints_along() -> None:
    talker, other = node('talker'), node('other')
    kept = endpoint(other, PUBLISHER, '/chatter', STRING)
    graph = graph_of(
        talker,
        other,
        endpoint(talker, PUBLISHER, '/chatter', STRING),
        endpoint(talker, SERVICE, '/add', ADD),
        kept,
    )
    graph.vanished(talker)
    assert graph.entities(PUBLISHER, '/chatter') == [kept]
    assert graph.service_names_and_types() == []


def test_the_departure_of_something_unknown_means_nothing() -> None:
    talker = node('talker')
    graph = graph_of(talker)
    calls: list[int] = []
    graph.on_change(lambda: calls.append(1))
    graph.vanished(node('stranger'))
    graph.vanished(endpoint(talker, PUBLISHER, '/chatter', STRING))
    assert (graph.nodes(), calls) == ([talker], [])


def test_counting_regards_the_name_alone() -> None:
    talker = node('talker')
    graph = graph_of(
        endpoint(talker, PUBLISHER, '/chatter', STRING),
        endpoint(talker, PUBLISHER, '/chatter', 'std_msgs/msg/Int32', QoS(depth=1)),
        endpoint(talker, SUBSCRIPTION, '/chatter', STRING),
    )
    assert [graph.count(kind, '/chatter') for kind in (PUBLISHER, SUBSCRIPTION, SERVICE, CLIENT)] == [
        2,
        1,
        0,
        0,
    ]


def test_topics_and_services_are_listed_with_all_their_types_in_order() -> None:
    talker = node('talker')
    graph = graph_of(
        endpoint(talker, PUBLISHER, '/b', STRING),
        endpoint(talker, SUBSCRIPTION, '/b', 'std_msgs/msg/Int32'),
        endpoint(talker, SUBSCRIPTION, '/a', STRING),
        endpoint(talker, CLIENT, '/add', ADD),
    )
    assert graph.topic_names_and_types() == [('/a', [STRING]), ('/b', ['std_msgs/msg/Int32', STRING])]
    assert graph.service_names_and_types() == [('/add', [ADD])]


def test_by_node_the_first_bearer_of_the_name_answers() -> None:
    first, second = node('twin'), node('twin')
    graph = graph_of(
        first,
        second,
        endpoint(second, PUBLISHER, '/second', STRING),
        endpoint(first, PUBLISHER, '/first', STRING),
        endpoint(first, SUBSCRIPTION, '/other', STRING),
    )
    assert graph.names_and_types_by_node(PUBLISHER, 'twin') == [('/first', [STRING])]
    assert graph.names_and_types_by_node(PUBLISHER, 'nobody') == []


@pytest.mark.parametrize(
    ('kind', 'name', 'type_name', 'expected'),
    [
        (SERVICE, '/add', ADD, True),
        (SERVICE, '/add', 'std_srvs/srv/Empty', False),
        (SERVICE, '/sub', ADD, False),
        (CLIENT, '/add', ADD, False),
    ],
)
def test_a_service_is_there_when_a_server_has_its_name_and_type(
    kind: EndpointKind, name: str, type_name: str, expected: bool
) -> None:
    graph = graph_of(endpoint(node('server'), kind, name, type_name))
    assert graph.has_service('/add', ADD) is expected


def test_matched_counterparts_agree_in_name_type_and_qos() -> None:
    best_effort = QoS(reliability=ReliabilityPolicy.BEST_EFFORT)
    listener = node('listener')
    agreeing = endpoint(listener, SUBSCRIPTION, '/chatter', STRING, best_effort)
    graph = graph_of(
        agreeing,
        endpoint(listener, SUBSCRIPTION, '/chatter', STRING),
        endpoint(listener, SUBSCRIPTION, '/chatter', 'std_msgs/msg/Int32', best_effort),
        endpoint(listener, SUBSCRIPTION, '/other', STRING, best_effort),
        enforces_qos=True,
    )
    assert graph.find_matched(Endpoint(PUBLISHER, '/chatter', STRING, '', best_effort)) == [agreeing]


def test_where_qos_prevents_nothing_name_and_type_make_a_match() -> None:
    listener = node('listener')
    reliable = endpoint(listener, SUBSCRIPTION, '/chatter', STRING)
    graph = graph_of(reliable, endpoint(listener, SUBSCRIPTION, '/chatter', 'std_msgs/msg/Int32'))
    best_effort = QoS(reliability=ReliabilityPolicy.BEST_EFFORT)
    assert graph.find_matched(Endpoint(PUBLISHER, '/chatter', STRING, '', best_effort)) == [reliable]


def test_a_subscription_matches_publishers_that_offer_enough() -> None:
    talker = node('talker')
    lasting = QoS(durability=DurabilityPolicy.TRANSIENT_LOCAL)
    offering = endpoint(talker, PUBLISHER, '/map', STRING, lasting)
    graph = graph_of(offering, endpoint(talker, PUBLISHER, '/map', STRING), enforces_qos=True)
    assert graph.find_matched(endpoint(node('listener'), SUBSCRIPTION, '/map', STRING, lasting)) == [offering]


def test_a_duration_nobody_asked_for_agrees_with_the_infinite_one_it_becomes_on_the_wire() -> None:
    infinite = QoS(deadline_ns=INFINITE_NS, lease_ns=INFINITE_NS)
    subscription = endpoint(node('listener'), SUBSCRIPTION, '/chatter', STRING, infinite)
    graph = graph_of(subscription, enforces_qos=True)
    assert graph.find_matched(Endpoint(PUBLISHER, '/chatter', STRING, '', QoS())) == [subscription]


def test_services_match_whatever_their_qos() -> None:
    server = endpoint(node('server'), SERVICE, '/add', ADD, QoS(reliability=ReliabilityPolicy.BEST_EFFORT))
    graph = graph_of(server, enforces_qos=True)
    assert graph.find_matched(endpoint(node('client'), CLIENT, '/add', ADD)) == [server]


FIBONACCI = 'example_interfaces/action/Fibonacci'
SERVER_PARTS = [
    (SERVICE, 'send_goal', f'{FIBONACCI}_SendGoal'),
    (SERVICE, 'cancel_goal', 'action_msgs/srv/CancelGoal'),
    (SERVICE, 'get_result', f'{FIBONACCI}_GetResult'),
    (PUBLISHER, 'feedback', f'{FIBONACCI}_FeedbackMessage'),
    (PUBLISHER, 'status', 'action_msgs/msg/GoalStatusArray'),
]


def action_server(owner: GraphEntity, without: str = '') -> list[GraphEntity]:
    return [
        endpoint(owner, kind, f'/fib/_action/{part}', type_name)
        for kind, part, type_name in SERVER_PARTS
        if part != without
    ]


def test_an_action_is_listed_for_its_server_and_its_client() -> None:
    server, client = node('server'), node('client')
    feedback = endpoint(client, SUBSCRIPTION, '/fib/_action/feedback', f'{FIBONACCI}_FeedbackMessage')
    graph = graph_of(*action_server(server), feedback)
    listed = [('/fib', [FIBONACCI])]
    assert graph.action_names_and_types() == listed
    assert graph.action_servers_by_node('server') == listed
    assert graph.action_servers_by_node('client') == []
    assert graph.action_clients_by_node('client') == listed
    assert graph.action_clients_by_node('server') == []


def test_an_action_server_is_there_with_all_its_parts() -> None:
    graph = graph_of(*action_server(node('server')))
    assert graph.has_action('/fib', FIBONACCI)
    assert not graph.has_action('/fib', 'example_interfaces/action/Other')


@pytest.mark.parametrize('part', [part for _, part, _ in SERVER_PARTS])
def test_an_action_server_is_not_there_while_a_part_is_missing(part: str) -> None:
    assert not graph_of(*action_server(node('server'), without=part)).has_action('/fib', FIBONACCI)


def test_every_change_is_told_after_it_happened() -> None:
    graph = Graph()
    seen: list[int] = []
    graph.on_change(lambda: seen.append(len(graph.nodes())))
    talker = node('talker')
    graph.appeared(talker)
    graph.appeared(node('other'))
    graph.vanished(talker)
    assert seen == [1, 2, 1]


def test_a_closed_watch_is_told_no_more() -> None:
    graph = Graph()
    calls: list[int] = []
    watch = graph.on_change(lambda: calls.append(1))
    watch.close()
    watch.close()
    graph.appeared(node('talker'))
    assert calls == []


def test_a_callback_may_close_its_own_watch_and_ask_the_graph() -> None:
    graph = Graph()
    found: list[bool] = []

    def on_change() -> None:
        found.append(graph.node_exists('talker'))
        watch.close()

    watch = graph.on_change(on_change)
    graph.appeared(node('talker'))
    graph.appeared(node('other'))
    assert found == [True]


def test_a_callback_that_raises_is_logged_and_spares_the_others(records: list[LogRecord]) -> None:
    graph = Graph()
    calls: list[int] = []
    graph.on_change(lambda: 1 / 0)
    graph.on_change(lambda: calls.append(1))
    graph.appeared(node('talker'))
    assert calls == [1]
    assert 'ZeroDivisionError' in records[-1].message


def test_threads_that_add_and_remove_at_once_leave_nothing_behind() -> None:
    graph = Graph()

    def come_and_go(session: str) -> None:
        for number in range(100):
            owner = node(f'n{number}', session=session)
            graph.appeared(owner)
            graph.appeared(endpoint(owner, PUBLISHER, '/chatter', STRING))
            graph.vanished(owner)

    threads = [Thread(target=come_and_go, args=(f's{number}',)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (graph.nodes(), graph.count(PUBLISHER, '/chatter'), graph.topic_names_and_types()) == ([], 0, [])


def test_two_thousand_endpoints_are_added_in_less_than_a_second_of_cpu() -> None:
    owners = [node(f'n{number}') for number in range(200)]
    endpoints = [
        endpoint(owners[number % 200], (PUBLISHER, SUBSCRIPTION)[number % 2], f'/topic{number % 50}', STRING)
        for number in range(2000)
    ]
    start = thread_time()
    graph = graph_of(*owners, *endpoints)
    assert thread_time() - start < 1.0
    assert len(graph.topic_names_and_types()) == 50
