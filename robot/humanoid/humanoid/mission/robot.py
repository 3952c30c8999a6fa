"""The robot as the mission sees it: its services and actions by what they do."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from contextlib import suppress
from types import TracebackType
from typing import Self

from geometry_msgs.msg import Point, Quaternion
from humanoid_interfaces.action import MoveArm, MoveToPosition
from humanoid_interfaces.srv import GetBatteryStatus, GetJointState
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from humanoid.mission.calls import GoalRun, call

ANSWER_WITHIN = 2.0  # s for a service call


class Robot:
    """A node with the clients of all the robot's services and actions, spinning until the block is left."""

    def __init__(self, name: str = 'mission') -> None:
        self.node = Node(name)
        self._joints = self.node.create_client(GetJointState, 'get_joint_state')
        self._battery = self.node.create_client(GetBatteryStatus, 'get_battery_status')
        self._base = ActionClient(self.node, MoveToPosition, 'move_to_position')
        self._arm = ActionClient(self.node, MoveArm, 'move_arm')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name='mission spin', daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._executor.shutdown()
        self._thread.join()
        self._arm.destroy()
        self._base.destroy()
        self.node.destroy_node()

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self._executor.spin()

    def joint(self, name: str, timeout: float = ANSWER_WITHIN) -> GetJointState.Response:
        response: GetJointState.Response = call(self._joints, GetJointState.Request(joint_name=name), timeout)
        return response

    def battery(self, timeout: float = ANSWER_WITHIN) -> GetBatteryStatus.Response:
        response: GetBatteryStatus.Response = call(self._battery, GetBatteryStatus.Request(), timeout)
        return response

    def drive(self, x: float, y: float, z: float = 0.0, *, allowed: float, timeout: float) -> GoalRun:
        """Send the base to (x, y, z) m; the server may take `allowed` seconds, the whole goal `timeout`."""
        goal = MoveToPosition.Goal()
        goal.target_pose.header.frame_id = 'odom'
        goal.target_pose.pose.position = Point(x=x, y=y, z=z)
        goal.target_pose.pose.orientation = Quaternion(w=1.0)
        goal.timeout = allowed
        return GoalRun(self._base, 'move_to_position', goal, timeout)

    def reach(self, joints: Mapping[str, float], *, duration: float, timeout: float) -> GoalRun:
        """Move joints to angles in rad."""
        goal = MoveArm.Goal()
        goal.joint_names = list(joints)
        goal.positions = list(joints.values())
        goal.duration = duration
        return GoalRun(self._arm, 'move_arm', goal, timeout)
