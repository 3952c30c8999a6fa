"""Item 8: a result that is asked for shortly before and after its time, in virtual time."""

from __future__ import annotations

import time

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from helpers.outcomes import Outcomes
from helpers.patience import PATIENCE
from helpers.spinning import Spinner, result_of
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import SingleThreadedExecutor

from goalwire.testing import VirtualClock

from .conftest import Evidence


def succeed(handle: ServerGoalHandle) -> Fibonacci.Result:
    handle.succeed()
    return Fibonacci.Result(sequence=[handle.request.order])


@pytest.mark.parametrize('transport_name', ['goalwire_memory'], indirect=True)
def test_a_result_is_there_for_ten_seconds_and_unknown_afterwards(
    isolated: dict[str, str], evidence: Evidence
) -> None:
    outcomes = Outcomes()
    with VirtualClock(), rclpy.init(args=[]):
        node = rclpy.create_node('node')
        ActionServer(node, Fibonacci, 'count', succeed)
        client = ActionClient(node, Fibonacci, 'count')
        with Spinner(SingleThreadedExecutor(), node):
            assert client.wait_for_server(PATIENCE)
            for seconds, status in ((9.9, GoalStatus.STATUS_SUCCEEDED), (10.1, GoalStatus.STATUS_UNKNOWN)):
                handle = result_of(client.send_goal_async(Fibonacci.Goal(order=1)))
                assert result_of(handle.get_result_async()).status == GoalStatus.STATUS_SUCCEEDED
                time.sleep(seconds)
                late = result_of(handle.get_result_async())
                assert late.status == status
                outcomes.note('there' if late.result.sequence else 'unknown')
        node.destroy_node()
    evidence(8, 'a result asked for 9.9 s and 10.1 s after the end (virtual time)', outcomes)
