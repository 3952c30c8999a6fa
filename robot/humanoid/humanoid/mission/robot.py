"""The robot for programs such as the mission: a method for each service and action."""

from __future__ import annotations

import threading
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Self, TypeVar

from control_msgs.action import GripperCommand
from geometry_msgs.msg import Point, Quaternion
from humanoid_interfaces.action import MoveArm, MoveToPosition
from humanoid_interfaces.srv import GetBatteryStatus, GetJointState
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from humanoid.emergency.names import SWITCH
from humanoid.mission.calls import FIND_WITHIN, GoalRun, call
from humanoid.mission.retry import NoAnswer

ANSWER_WITHIN = 2.0  # s to wait for the response of a service
DOORS = 'doors'
LOCALISED = 'amcl_pose'  # topic of the localiser: it has a publisher if the robot has a map
HAND = 'left_gripper_controller/gripper_cmd'

Told = TypeVar('Told')


class Robot:
    """A node with clients of the robot's services and actions, spinning until the block is left.

    Clients that the short mission of ten steps does not need are created at their first use.
    """

    def __init__(self, name: str = 'mission') -> None:
        self.node = Node(name)
        self._joints = self.node.create_client(GetJointState, 'get_joint_state')
        self._battery = self.node.create_client(GetBatteryStatus, 'get_battery_status')
        self._base = ActionClient(self.node, MoveToPosition, 'move_to_position')
        self._arm = ActionClient(self.node, MoveArm, 'move_arm')
        self._hand: ActionClient | None = None
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
        if self._hand is not None:
            self._hand.destroy()
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

    def next_message(self, type_: type[Told], topic: str, qos: QoSProfile | int = 1) -> Told:
        """Return the next message of a topic. Raises NoAnswer."""
        came: SimpleQueue[Told] = SimpleQueue()
        subscription = self.node.create_subscription(type_, topic, came.put, qos)
        try:
            return came.get(timeout=ANSWER_WITHIN)
        except Empty:
            raise NoAnswer(f'{topic}: no message within {ANSWER_WITHIN:.1f} s') from None
        finally:
            self.node.destroy_subscription(subscription)

    @property
    def in_world(self) -> bool:
        """True if the robot localises itself on a map; False also until its publisher is discovered."""
        return bool(self.node.count_publishers(LOCALISED))

    def drive(
        self, x: float, y: float, z: float = 0.0, *, allowed: float, timeout: float, frame: str = ''
    ) -> GoalRun:
        """Send the base to (x, y, z) m in `frame`; by default on the map if there is one, else in `odom`.

        `allowed`: the goal's time limit, in s. `timeout`: s for the whole goal, waiting included.
        """
        self._base.wait_for_server(timeout_sec=FIND_WITHIN)  # by then discovery has also found the localiser
        goal = MoveToPosition.Goal()
        goal.target_pose.header.frame_id = frame or ('map' if self.in_world else 'odom')
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

    def grip(self, gap: float, *, timeout: float) -> GoalRun:
        """Open or close the left hand until its fingers are `gap` m apart."""
        if self._hand is None:
            self._hand = ActionClient(self.node, GripperCommand, HAND)
        goal = GripperCommand.Goal()
        goal.command.position = gap
        return GoalRun(self._hand, HAND, goal, timeout)

    def wave(self, timeout: float) -> Trigger.Response:
        """Make the robot wave; return the response, which comes when it has waved."""
        client = self.node.create_client(Trigger, 'wave')
        response: Trigger.Response = call(client, Trigger.Request(), timeout)
        return response

    def emergency_stop(self, *, stopped: bool, timeout: float = ANSWER_WITHIN) -> SetBool.Response:
        """Throw the switch of the emergency stop, or release it."""
        client = self.node.create_client(SetBool, SWITCH)
        response: SetBool.Response = call(client, SetBool.Request(data=stopped), timeout)
        return response

    def doors(self) -> Sequence[str]:
        """Return the names of the world's doors. Raises NoAnswer if there is no robot."""
        if not self._battery.wait_for_service(timeout_sec=ANSWER_WITHIN):  # by then all doors are discovered
            raise NoAnswer(f'{self._battery.srv_name}: no server within {ANSWER_WITHIN:.1f} s')
        prefix = self.node.resolve_service_name(f'{DOORS}/x').removesuffix('x')
        names = [name for name, _ in self.node.get_service_names_and_types() if name.startswith(prefix)]
        return sorted(name.removeprefix(prefix) for name in names)

    def move_door(self, name: str, *, is_open: bool) -> SetBool.Response:
        """Open a door of the world, or close it."""
        client = self.node.create_client(SetBool, f'{DOORS}/{name}')
        response: SetBool.Response = call(client, SetBool.Request(data=is_open), ANSWER_WITHIN)
        return response

    @contextmanager
    def joint_states(self) -> Generator[SimpleQueue[JointState], None, None]:
        """Give a queue of the joint states that arrive while the block runs."""
        came: SimpleQueue[JointState] = SimpleQueue()
        subscription = self.node.create_subscription(JointState, 'joint_states', came.put, 10)
        try:
            yield came
        finally:
            self.node.destroy_subscription(subscription)
