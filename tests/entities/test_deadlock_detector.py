"""Whether a blocking call could ever be answered by a server of this process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from goalwire.entities.deadlock_detector import DeadlockDetector
from goalwire.errors import WouldDeadlockError
from goalwire.execution.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from goalwire.execution.current_callback import held_groups
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.graph.graph import Graph
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName


def graph_with(servers: int) -> Graph:
    graph = Graph()
    for number in range(servers):
        graph.appeared(
            GraphEntity(
                EndpointKind.SERVICE,
                's',
                number,
                NodeName('n'),
                '/add',
                'p/srv/Add',
                gid=bytes([number] * 16),
            )
        )
    return graph


def inbox_in(group: CallbackGroup) -> EventQueue[Any]:
    return EventQueue(NodeWorkQueue(), group, lambda _: None)


@pytest.fixture
def held() -> MutuallyExclusiveCallbackGroup:
    """A group that the running callback holds."""
    return MutuallyExclusiveCallbackGroup()


def inside(held: MutuallyExclusiveCallbackGroup, ask: Callable[[], None]) -> None:
    token = held_groups.set((held,))
    try:
        ask()
    finally:
        held_groups.reset(token)


def test_a_name_that_nobody_here_serves_is_no_matter(held: MutuallyExclusiveCallbackGroup) -> None:
    inside(held, lambda: DeadlockDetector().check(graph_with(1), '/add'))


def test_a_server_in_the_held_group_can_never_answer(held: MutuallyExclusiveCallbackGroup) -> None:
    servers = DeadlockDetector()
    servers.add('/add', inbox_in(held))
    with pytest.raises(WouldDeadlockError, match=r"^a blocking call of '/add' can never be answered: "):
        inside(held, lambda: servers.check(graph_with(1), '/add'))
    servers.check(graph_with(1), '/add')  # outside the callback it can


def test_one_server_that_can_answer_is_enough(held: MutuallyExclusiveCallbackGroup) -> None:
    servers = DeadlockDetector()
    servers.add('/add', inbox_in(held))
    servers.add('/add', inbox_in(MutuallyExclusiveCallbackGroup()))
    inside(held, lambda: servers.check(graph_with(2), '/add'))


def test_a_server_elsewhere_may_answer(held: MutuallyExclusiveCallbackGroup) -> None:
    servers = DeadlockDetector()
    servers.add('/add', inbox_in(held))
    inside(held, lambda: servers.check(graph_with(2), '/add'))


def test_a_server_that_went_is_forgotten(held: MutuallyExclusiveCallbackGroup) -> None:
    servers, event_queue = DeadlockDetector(), inbox_in(held)
    servers.add('/add', event_queue)
    servers.remove('/add', event_queue)
    inside(held, lambda: servers.check(graph_with(0), '/add'))
