"""The hints that the graph gives to a call that found nobody."""

from __future__ import annotations

import pytest

from goalwire.graph.graph import Graph
from goalwire.graph.near_misses import near_misses, similar_names
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName

SERVICE, CLIENT = EndpointKind.SERVICE, EndpointKind.CLIENT
SET, TRIGGER = 'std_srvs/srv/SetBool', 'std_srvs/srv/Trigger'


def graph(*endpoints: tuple[EndpointKind, str, str, str]) -> Graph:
    """Make one of (kind, node, name, type)."""
    graph = Graph('ours')
    for number, (kind, node, name, type_name) in enumerate(endpoints):
        session = 'ours' if kind is CLIENT else 'theirs'
        gid = number.to_bytes(16, 'little')
        graph.appeared(GraphEntity(kind, session, number, NodeName(node), name, type_name, gid=gid))
    return graph


def test_another_namespace_comes_before_another_spelling() -> None:
    names = ['/robot/lamp', '/lamps', '/switch', '/robot/lamps']
    assert similar_names('/lamp', names) == ['/robot/lamp', '/lamps']
    assert similar_names('/robot/lamp', ['/lamp']) == ['/lamp']


@pytest.mark.parametrize(
    ('name', 'hint'),
    [
        ('/lamp', "did you mean '/robot/lamp' of the node '/arm'?"),
        ('/robot/lmap', "did you mean '/robot/lamp' of the node '/arm'?"),
        ('/gripper', ''),
    ],
)
def test_a_similar_name_is_shown_with_its_node(name: str, hint: str) -> None:
    there = graph((CLIENT, 'me', name, SET), (SERVICE, 'arm', '/robot/lamp', SET))
    assert near_misses(there, name, is_action=False) == hint


def test_another_type_is_shown_with_both_nodes() -> None:
    there = graph((CLIENT, 'me', '/lamp', SET), (SERVICE, 'arm', '/lamp', TRIGGER))
    assert near_misses(there, '/lamp', is_action=False) == (
        f"node '/arm' serves that name with the type {TRIGGER}, node '/me' asks for {SET}"
    )


def test_actions_are_compared_with_actions() -> None:
    there = graph(
        (CLIENT, 'me', '/walk/_action/send_goal', 'a/action/Walk_SendGoal'),
        (SERVICE, 'legs', '/robot/walk/_action/send_goal', 'a/action/Walk_SendGoal'),
        (SERVICE, 'legs', '/robot/walk/_action/get_result', 'a/action/Walk_GetResult'),
        (SERVICE, 'dog', '/walks', SET),
    )
    assert near_misses(there, '/walk', is_action=True) == "did you mean '/robot/walk' of the node '/legs'?"
    assert near_misses(there, '/walk', is_action=False) == "did you mean '/walks' of the node '/dog'?"


def test_an_action_of_another_type_is_named_as_users_know_it() -> None:
    there = graph(
        (CLIENT, 'me', '/walk/_action/send_goal', 'a/action/Walk_SendGoal'),
        (SERVICE, 'legs', '/walk/_action/send_goal', 'a/action/Run_SendGoal'),
    )
    assert near_misses(there, '/walk', is_action=True) == (
        "node '/legs' serves that name with the type a/action/Run, node '/me' asks for a/action/Walk"
    )


def test_nothing_is_said_where_the_server_is_there() -> None:
    there = graph(
        (CLIENT, 'me', '/lamp', SET), (SERVICE, 'arm', '/lamp', SET), (SERVICE, 'arm', '/lamps', SET)
    )
    assert near_misses(there, '/lamp', is_action=False) == ''
