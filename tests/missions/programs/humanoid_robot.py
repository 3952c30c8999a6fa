"""The humanoid's servers in one process: `humanoid_robot.py EXECUTIONS`.

Each goal that begins is written into the file of executions.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import rclpy
from humanoid.arm.controllers import Controller
from humanoid.arm.server import ArmActionServer
from humanoid.battery.service import BatteryService
from humanoid.joints.service import JointStateService
from humanoid.navigation.server import NavigationActionServer
from rclpy.executors import SingleThreadedExecutor


def noting(begin: Callable[[Any, Any], None], executions: IO[str]) -> Callable[[Any, Any], None]:
    """Return the method that begins a goal, and that notes this first."""

    def note_and_begin(server: Any, goal: Any) -> None:
        print(bytes(goal.goal_id.uuid).hex(), type(server).__name__, file=executions, flush=True)
        begin(server, goal)

    return note_and_begin


def main(path: str) -> None:
    with Path(path).open('a', encoding='utf-8') as executions, rclpy.init(args=[]):
        for server, method in (
            (NavigationActionServer, '_begin'),
            (ArmActionServer, '_begin'),
            (Controller, '_accept'),
        ):
            setattr(server, method, noting(getattr(server, method), executions))
        for make_node in (JointStateService, NavigationActionServer, ArmActionServer, BatteryService):
            executor = SingleThreadedExecutor()
            executor.add_node(make_node())
            threading.Thread(target=executor.spin, daemon=True).start()
        print('ready', flush=True)
        threading.Event().wait()


main(sys.argv[1])
