"""The emergency stop: one node has the switch, all servers obey it.

`emergency_stop` is a service (std_srvs/SetBool: true stops, false releases) and a topic (std_msgs/Bool) for
buttons: true stops, and false does nothing, for only the service releases. The topic `emergency_stopped`
(std_msgs/Bool, latched) tells how it stands, to late comers too.
"""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

SWITCH = 'emergency_stop'
STATE = 'emergency_stopped'
REFUSAL = f'emergency stop: nothing moves until {SWITCH} is called with false'
ENDED = 'Emergency stop'


def _latched() -> QoSProfile:
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class StopSwitch:
    """The switch itself: `stopped` says how it stands, `on_stop` is called as soon as it is thrown."""

    def __init__(self, node: Node, on_stop: Callable[[], None]) -> None:
        self.stopped = False
        self._node, self._on_stop = node, on_stop
        self._state = node.create_publisher(Bool, STATE, _latched())
        node.create_service(SetBool, SWITCH, self._asked)
        node.create_subscription(Bool, SWITCH, self._pressed, 10)
        self._state.publish(Bool(data=False))

    def _asked(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._turn(stopped=request.data)
        response.success, response.message = True, 'stopped' if self.stopped else 'released'
        return response

    def _pressed(self, button: Bool) -> None:
        if button.data:
            self._turn(stopped=True)

    def _turn(self, *, stopped: bool) -> None:
        """Stopping twice stops twice: what has come to move in between is told to hold."""
        changed, self.stopped = self.stopped != stopped, stopped
        if stopped:
            self._on_stop()
        self._state.publish(Bool(data=stopped))
        if changed:
            self._node.get_logger().warning('EMERGENCY STOP' if stopped else 'Emergency stop released')


class StopListener:
    """How the switch stands, as a server knows it; `on_stop` is called whenever it is thrown."""

    def __init__(self, node: Node, on_stop: Callable[[], None]) -> None:
        self.stopped = False
        self._on_stop = on_stop
        node.create_subscription(Bool, STATE, self._hear, _latched())

    def _hear(self, state: Bool) -> None:
        self.stopped = state.data
        if state.data:
            self._on_stop()
