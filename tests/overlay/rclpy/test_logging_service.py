"""The services that read and set the levels of loggers."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy.logging
from helpers.spinning import MakeNode, Spin, result_of
from rcl_interfaces.msg import LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.node import Node


@pytest.fixture(autouse=True)
def fresh_levels() -> Iterator[None]:
    rclpy.logging.clear_config()
    yield
    rclpy.logging.clear_config()


@pytest.fixture
def node(make_node: MakeNode, spin: Spin) -> Node:
    """A spun node, /ns/logs."""
    node = make_node('logs', namespace='ns', enable_logger_service=True)
    spin(node)
    return node


def levels(node: Node, *names: str) -> list[tuple[str, int]]:
    client = node.create_client(GetLoggerLevels, '/ns/logs/get_logger_levels')
    answer = result_of(client.call_async(GetLoggerLevels.Request(names=list(names))))
    return [(level.name, level.level) for level in answer.levels]


def set_levels(node: Node, *wanted: tuple[str, int]) -> list[tuple[bool, str]]:
    client = node.create_client(SetLoggerLevels, '/ns/logs/set_logger_levels')
    request = SetLoggerLevels.Request(levels=[LoggerLevel(name=name, level=level) for name, level in wanted])
    answer = result_of(client.call_async(request))
    return [(result.successful, result.reason) for result in answer.results]


def test_a_node_offers_them_only_where_it_was_asked_to(make_node: MakeNode, node: Node) -> None:
    def offered(of: Node) -> list[str]:
        return [service.service_name for service in of.services if 'logger' in service.service_name]

    assert offered(node) == ['/ns/logs/get_logger_levels', '/ns/logs/set_logger_levels']
    assert offered(make_node('silent')) == []


def test_levels_are_read_as_they_were_set(node: Node) -> None:
    rclpy.logging.set_logger_level('q', LoggingSeverity.ERROR)
    assert levels(node, 'q', 'q.child', 'nope', '') == [('q', 40), ('q.child', 0), ('nope', 0), ('', 20)]


def test_levels_are_set_one_by_one_and_what_is_none_is_refused(node: Node) -> None:
    assert set_levels(node, ('ns.logs', 10), ('q', 77), ('r', 50)) == [
        (True, ''),
        (False, 'Failed reason: Invalid logger level.'),
        (True, ''),
    ]
    assert node.get_logger().get_effective_level() is LoggingSeverity.DEBUG
    assert levels(node, 'ns.logs', 'q', 'r') == [('ns.logs', 10), ('q', 0), ('r', 50)]


def test_unset_returns_to_the_level_of_the_ancestors(node: Node) -> None:
    set_levels(node, ('', 40), ('q', 10))
    set_levels(node, ('q', 0))
    assert rclpy.logging.get_logger_effective_level('q') is LoggingSeverity.ERROR
