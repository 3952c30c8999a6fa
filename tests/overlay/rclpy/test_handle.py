"""Handles: what programs hold of rclpy's C++ objects."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from helpers.spinning import MakeNode
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

MAKERS: dict[str, Callable[[Node], object]] = {
    'publisher': lambda node: node.create_publisher(String, 'chat', 1),
    'subscription': lambda node: node.create_subscription(String, 'chat', print, 1),
    'client': lambda node: node.create_client(Trigger, 'help'),
    'service': lambda node: node.create_service(Trigger, 'help', lambda request, response: response),
    'timer': lambda node: node.create_timer(1.0, print),
    'guard_condition': lambda node: node.create_guard_condition(print),
}


@pytest.fixture
def transport_name() -> str:
    """Which wire it is does not matter here."""
    return 'goalwire_memory'


@pytest.mark.parametrize('kind', MAKERS)
def test_the_block_of_a_handle_leaves_its_entity_alone(make_node: MakeNode, kind: str) -> None:
    node = make_node()
    entity = MAKERS[kind](node)
    with entity.handle:  # type: ignore[attr-defined]
        pass
    with entity.handle:  # type: ignore[attr-defined]
        pass
    assert getattr(node, f'destroy_{kind}')(entity)
    with pytest.raises(InvalidHandle), entity.handle:  # type: ignore[attr-defined]
        pass


def test_the_blocks_of_clock_context_and_node_leave_them_alone(make_node: MakeNode) -> None:
    node = make_node('n')
    with node.get_clock().handle, node.context.handle, node.handle:  # type: ignore[attr-defined]
        pass
    assert node.context.ok()
    assert node.get_clock().now().nanoseconds > 0
    assert node.get_fully_qualified_name() == '/n'


def test_a_handle_has_what_its_entity_has(make_node: MakeNode) -> None:
    publisher = make_node().create_publisher(String, 'chat', 1)
    assert publisher.handle.topic_name == '/chat'
    assert isinstance(publisher.handle, type(publisher))
    assert publisher.handle == publisher.handle
    assert len({publisher.handle, publisher.handle}) == 1
    with pytest.raises(AttributeError, match='rudder'):
        _ = publisher.handle.rudder  # type: ignore[attr-defined]
