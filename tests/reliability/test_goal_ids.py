"""Item 3: one goal id used by two clients at a time, and again."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from example_interfaces.action import Fibonacci
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, result_of
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from .conftest import Evidence

THE_ID = UUID(uuid=list(range(16)))


def succeed(handle: ServerGoalHandle) -> Fibonacci.Result:
    handle.succeed()
    return Fibonacci.Result(sequence=[handle.request.order])


@pytest.fixture
def nodes(isolated: dict[str, str]) -> Iterator[list[Node]]:
    """A server's node and two for clients, each in a context of its own."""
    contexts = [Context() for _ in range(3)]
    for context in contexts:
        context.init(args=[])
    yield [Node(f'node{number}', context=context) for number, context in enumerate(contexts)]
    for context in contexts:
        context.try_shutdown()


def test_of_two_goals_with_one_id_one_is_accepted_and_the_id_stays_taken_until_its_result_expires(
    nodes: list[Node], evidence: Evidence
) -> None:
    outcomes = Outcomes()
    ActionServer(nodes[0], Fibonacci, 'count', succeed, result_timeout=900)
    ActionServer(nodes[0], Fibonacci, 'forget', succeed, result_timeout=0)
    clients = [ActionClient(node, Fibonacci, 'count') for node in nodes[1:]]
    forgetful = ActionClient(nodes[1], Fibonacci, 'forget')

    def send(*clients: ActionClient) -> list[bool]:
        """Let the clients use the id at the same time; return who was accepted, and wait for that goal."""
        goals = [client.send_goal_async(Fibonacci.Goal(order=1), None, THE_ID) for client in clients]
        handles = [result_of(goal) for goal in goals]
        for handle in handles:
            outcomes.note('accepted' if handle.accepted else 'refused')
            if handle.accepted:
                result_of(handle.get_result_async())
        return sorted(handle.accepted for handle in handles)

    with Spinner(MultiThreadedExecutor(4, context=nodes[0].context), nodes[0]):
        assert all(client.wait_for_server(PATIENCE) for client in (*clients, forgetful))
        assert send(*clients) == [False, True]
        assert send(*clients) == [False, False]
        assert [send(forgetful) for _ in range(2)] == [[True], [True]]
    evidence(
        3, 'two clients send one goal id at a time, then both again; and after its result expired', outcomes
    )
