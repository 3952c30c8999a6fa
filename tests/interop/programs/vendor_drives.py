"""Serves the action `drive` under the real rclpy, and writes each execution into a file.

`-` stands where servers of goalwire write how many goals they have refused: rclpy does not count them.
Every eighth goal takes longer, so that a runner that was killed and started again finds it running.
"""

from __future__ import annotations

import sys
import time
from contextlib import suppress
from pathlib import Path

import rclpy
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from test_msgs.action import Fibonacci  # type: ignore[import-not-found]  # of the real rclpy

executions = Path(sys.argv[1]).open('a', encoding='utf-8')  # noqa: SIM115 - for as long as this runs


def drive(goal: ServerGoalHandle) -> Fibonacci.Result:
    goal_id = bytes(goal.goal_id.uuid).hex()
    print(goal_id, 'begun', '-', time.monotonic(), file=executions, flush=True)
    time.sleep(5.0 if goal.request.order % 8 == 3 else 0.5)
    print(goal_id, 'ended', '-', time.monotonic(), file=executions, flush=True)
    goal.succeed()
    return Fibonacci.Result(sequence=[goal.request.order])


rclpy.init()
node = rclpy.create_node('base')
ActionServer(node, Fibonacci, 'drive', drive, callback_group=ReentrantCallbackGroup())
executor = MultiThreadedExecutor(8)
executor.add_node(node)
print('ready', flush=True)
with suppress(KeyboardInterrupt, ExternalShutdownException):
    executor.spin()
