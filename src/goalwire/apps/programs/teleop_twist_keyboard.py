"""teleop_twist_keyboard: drives a robot's /cmd_vel by keys of a terminal.

Each key press sends one command. Space, every key without a meaning, and the end of the program send a stop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from goalwire.apps.programs.keyboard import interrupt_on_signals, is_terminal, keys
from goalwire.apps.programs.running import declare_number, declare_text

HELP = """
This node takes keypresses from the keyboard and publishes them as {kind} messages.
---------------------------
Moving around:
   u    i    o
   j    k    l
   m    ,    .

For holonomic mode (strafing), hold down the shift key:
---------------------------
   U    I    O
   J    K    L
   M    <    >

t : up (+z)
b : down (-z)

anything else : stop

q/z : increase/decrease max speeds by 10%
w/x : increase/decrease only linear speed by 10%
e/c : increase/decrease only angular speed by 10%

CTRL-C to quit
"""
MOVES = {
    'i': (1, 0, 0, 0),
    'o': (1, 0, 0, -1),
    'j': (0, 0, 0, 1),
    'l': (0, 0, 0, -1),
    'u': (1, 0, 0, 1),
    ',': (-1, 0, 0, 0),
    '.': (-1, 0, 0, 1),
    'm': (-1, 0, 0, -1),
    'O': (1, -1, 0, 0),
    'I': (1, 0, 0, 0),
    'J': (0, 1, 0, 0),
    'L': (0, -1, 0, 0),
    'U': (1, 1, 0, 0),
    '<': (-1, 0, 0, 0),
    '>': (-1, -1, 0, 0),
    'M': (-1, 1, 0, 0),
    't': (0, 0, 1, 0),
    'b': (0, 0, -1, 0),
}
"""By key: x, y, z and turn, each as a factor of the speed."""
SPEEDS = {
    'q': (1.1, 1.1),
    'z': (0.9, 0.9),
    'w': (1.1, 1.0),
    'x': (0.9, 1.0),
    'e': (1.0, 1.1),
    'c': (1.0, 0.9),
}
"""By key: the factors by which speed and turn change."""


class TeleopTwistKeyboard(Node):
    """Publishes Twist, or TwistStamped if the parameter `stamped` is true, on `cmd_vel`.

    Parameters: `stamped`, `frame_id` of the stamped message, `speed` in m/s and `turn` in rad/s at the start.
    """

    def __init__(self) -> None:
        super().__init__('teleop_twist_keyboard')
        self.is_stamped = bool(self.declare_parameter('stamped', value=False).value)
        self._frame = declare_text(self, 'frame_id', '')
        self.speed = self._positive('speed', 0.5)
        self.turn = self._positive('turn', 1.0)
        self._publisher = self.create_publisher(TwistStamped if self.is_stamped else Twist, 'cmd_vel', 10)

    def _positive(self, name: str, default: float) -> float:
        value = declare_number(self, name, default)
        if 0.0 < value < math.inf:
            return value
        self.get_logger().warning(f'The parameter {name} is {value}: it must be above 0; {default} is used')
        return default

    def send(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> None:
        """Publish a velocity in m/s and rad/s; without arguments a stop."""
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.linear.z = x, y, z
        twist.angular.z = turn
        if not self.is_stamped:
            self._publisher.publish(twist)
            return
        stamped = TwistStamped(twist=twist)
        stamped.header.stamp = self.get_clock().now().to_msg()
        stamped.header.frame_id = self._frame
        self._publisher.publish(stamped)

    def press(self, key: str) -> bool:
        """Carry out a key; return True if the speeds have changed."""
        if key in SPEEDS:
            linear, angular = SPEEDS[key]
            self.speed *= linear
            self.turn *= angular
            return True
        x, y, z, turn = MOVES.get(key, (0, 0, 0, 0))
        self.send(x * self.speed, y * self.speed, z * self.speed, turn * self.turn)
        return False


def _drive(node: TeleopTwistKeyboard) -> None:
    try:
        with keys() as pressed:
            print(HELP.format(kind='TwistStamped' if node.is_stamped else 'Twist'))
            print(f'currently:\tspeed {node.speed}\tturn {node.turn} ', flush=True)
            for key in pressed:
                if node.press(key):
                    print(f'currently:\tspeed {node.speed}\tturn {node.turn} ', flush=True)
    finally:
        if node.context.ok():
            node.send()


def main(args: Sequence[str] | None = None) -> int:
    """Drive until Ctrl-C or the end of the input, then stop the robot."""
    if not is_terminal('teleop_twist_keyboard'):
        return 1
    try:
        interrupt_on_signals()
        with rclpy.init(
            args=None if args is None else list(args), signal_handler_options=SignalHandlerOptions.NO
        ):
            _drive(TeleopTwistKeyboard())
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    return 0
