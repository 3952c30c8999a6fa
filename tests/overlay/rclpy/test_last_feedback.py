"""spin_until_future_complete leaves nothing behind that came before its future's end."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import Executor

COUNT = 20


@pytest.mark.parametrize('late', [False, True], ids=['spinning before', 'spinning after'])
def test_a_burst_of_feedback_is_seen_before_the_result(
    make_node: MakeNode, spin: Spin, executor: Executor, late: bool
) -> None:
    go = threading.Event()

    def execute(handle: ServerGoalHandle) -> Any:
        assert go.wait(PATIENCE)
        for number in range(COUNT):
            handle.publish_feedback(Fibonacci.Feedback(sequence=[number]))
        handle.succeed()
        return Fibonacci.Result(sequence=[COUNT])

    server_node, client_node = make_node('server'), make_node('client')
    ActionServer(server_node, Fibonacci, 'count', execute)
    client = ActionClient(client_node, Fibonacci, 'count')
    assert client.wait_for_server(PATIENCE)
    spin(server_node)
    executor.add_node(client_node)
    seen: list[int] = []
    sending = client.send_goal_async(
        Fibonacci.Goal(order=1), lambda message: seen.extend(message.feedback.sequence)
    )
    executor.spin_until_future_complete(sending, PATIENCE)
    result = result_of(sending).get_result_async()
    go.set()
    if late:
        result_of(result)
    executor.spin_until_future_complete(result, PATIENCE)
    assert result.done()
    assert seen == list(range(COUNT))
