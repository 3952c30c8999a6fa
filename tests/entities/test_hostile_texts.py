"""Texts of peers in errors and logs, on every wire: they forge no line and steer no terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import pytest
import rclpy
from example_interfaces.action import Fibonacci
from helpers.spinning import Spinner, result_of
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

from goalwire.errors import ServerFailedError
from goalwire.logging import LogRecord

pytestmark = pytest.mark.also_on_dds

HOSTILE = 'no\n[FATAL] [1.0] [client]: forged\x1b[2J\u202e\u2028'
TOLD = r'no\n[FATAL] [1.0] [client]: forged\x1b[2J\u202e\u2028'


Sides: TypeAlias = tuple[Node, Node, Spinner]


def fail(*_: object) -> Any:
    raise ValueError(HOSTILE)


@pytest.fixture
def nodes(isolated: dict[str, str]) -> Iterator[Sides]:
    """A client's node and a server's, in two contexts, and what spins the server's."""
    contexts = Context(), Context()
    with rclpy.init(context=contexts[0]), rclpy.init(context=contexts[1]):
        client, server = (
            Node(name, context=each) for name, each in zip(('client', 'server'), contexts, strict=True)
        )
        with (
            MultiThreadedExecutor(2, context=contexts[0]) as near,
            MultiThreadedExecutor(2, context=contexts[1]) as far,
            Spinner(near, client),
            Spinner(far, server) as spinner,
        ):
            yield client, server, spinner


def test_what_a_servers_callback_raised(nodes: Sides) -> None:
    node, server, spinner = nodes
    server.create_service(Trigger, 'go', fail)
    client = node.create_client(Trigger, 'go')
    assert client.wait_for_service(10)
    client.call_timeout = 10.0
    with pytest.raises(ServerFailedError) as caught:
        client.call(Trigger.Request())
    assert TOLD in str(caught.value)
    assert str(caught.value).isprintable()
    spinner.expect_raised(ValueError)


def test_what_an_execute_callback_raised(nodes: Sides, records: list[LogRecord]) -> None:
    node, server, _ = nodes
    ActionServer(server, Fibonacci, 'count', fail)
    client = ActionClient(node, Fibonacci, 'count')
    assert client.wait_for_server(10)
    handle = result_of(client.send_goal_async(Fibonacci.Goal()))
    result_of(handle.get_result_async())
    (told,) = [record.message for record in records if 'execute callback' in record.message]
    assert told.replace('\n', '').isprintable()
    assert f': {TOLD}; so the goal is aborted' in told.split('\n')[0]
    assert [line for line in told.split('\n') if line.startswith('[')] == []
