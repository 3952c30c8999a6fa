"""turtle_teleop_key: drives turtle1 by the arrow keys."""

from __future__ import annotations

from collections.abc import Sequence

import rclpy
from geometry_msgs.msg import Twist
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from turtlesim.action import RotateAbsolute

from goalwire.apps.programs.keyboard import (
    DOWN,
    LEFT,
    RIGHT,
    UP,
    interrupt_on_signals,
    is_terminal,
    keys,
)
from goalwire.apps.programs.running import declare_number

HELP = """Reading from keyboard
---------------------------
Use arrow keys to move the turtle.
Use g|b|v|c|d|e|r|t keys to rotate to absolute orientations. 'f' to cancel a rotation.
'q' to quit."""
ARROWS = {UP: (1.0, 0.0), DOWN: (-1.0, 0.0), LEFT: (0.0, 1.0), RIGHT: (0.0, -1.0)}
"""By key: forward and turn, each as a factor of its scale."""
HEADINGS = {
    'g': 0.0,
    't': 0.7854,
    'r': 1.5708,
    'e': 2.3562,
    'd': 3.1416,
    'c': -2.3562,
    'v': -1.5708,
    'b': -0.7854,
}
"""By key: a heading in rad. A key lies in the direction from F into which it turns the turtle."""


class TeleopTurtle(Node):
    """Publishes `turtle1/cmd_vel` and sends goals to `turtle1/rotate_absolute`.

    Parameters: `scale_linear` in units/s, `scale_angular` in rad/s.
    """

    def __init__(self) -> None:
        super().__init__('teleop_turtle')
        self._turn = declare_number(self, 'scale_angular', 2.0)
        self._forward = declare_number(self, 'scale_linear', 2.0)
        self._publisher = self.create_publisher(Twist, 'turtle1/cmd_vel', 1)
        self._client = ActionClient(self, RotateAbsolute, 'turtle1/rotate_absolute')
        self._goal: Future[ClientGoalHandle] | None = None

    def press(self, key: str) -> bool:
        """Carry out a key; return False for the key that ends the program."""
        key = key if key in ARROWS else key.lower()
        if key in ARROWS:
            forward, turn = ARROWS[key]
            twist = Twist()
            twist.linear.x, twist.angular.z = forward * self._forward, turn * self._turn
            self._publisher.publish(twist)
        elif key in HEADINGS:
            self._goal = self._client.send_goal_async(RotateAbsolute.Goal(theta=HEADINGS[key]))
        elif key == 'f' and self._goal is not None:
            self._goal.add_done_callback(_cancel)
        return key != 'q'


def _cancel(goal: Future[ClientGoalHandle]) -> None:
    handle = goal.result()
    if handle is not None and handle.accepted:
        handle.cancel_goal_async().add_done_callback(lambda _: None)


def main(args: Sequence[str] | None = None) -> int:
    """Drive until q or Ctrl-C."""
    if not is_terminal('turtle_teleop_key'):
        return 1
    try:
        interrupt_on_signals()
        with rclpy.init(
            args=None if args is None else list(args), signal_handler_options=SignalHandlerOptions.NO
        ):
            node = TeleopTurtle()
            with keys() as pressed:
                print(HELP, flush=True)
                for key in pressed:
                    if not node.press(key):
                        break
                    rclpy.spin_once(node, timeout_sec=0)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    return 0
