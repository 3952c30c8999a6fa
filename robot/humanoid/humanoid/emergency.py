"""The emergency stop: one node has the switch, all servers obey it.

`emergency_stop` is a service (std_srvs/SetBool: true stops, false releases) and a topic (std_msgs/Bool) for
buttons: true stops, and false does nothing, for only the service releases. The topic `emergency_stopped`
(std_msgs/Bool, latched) tells how it stands, to late comers too, and is repeated for as long as there is a
switch. `emergency_stop_status` (diagnostic_msgs/DiagnosticStatus, latched) says why it is stopped, and who
did it. A server that no longer hears the switch stops: nobody could stop it otherwise. It then presses the
button of the next switch that it hears, so a switch that is back is thrown, and somebody has to release it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from humanoid.graph import client_nodes, one_of, publisher_nodes
from humanoid.text import brief

SWITCH = 'emergency_stop'
STATE = 'emergency_stopped'
STATUS = 'emergency_stop_status'
TOLD_EVERY = 0.2  # s, of the steady clock: a simulation that pauses is not without its switch
MISSED = 5  # times that a state was due and did not come: after 1 s the switch is gone
REFUSAL = f'emergency stop: nothing moves until {SWITCH} is called with false'
ENDED = 'Emergency stop'
GONE = 'its switch is gone: is joint_state_service running?'


def _latched() -> QoSProfile:
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def _steady() -> Clock:
    return Clock(clock_type=ClockType.STEADY_TIME)


class StopSwitch:
    """The switch itself: `stopped` says how it stands, `on_stop` is called as soon as it is thrown."""

    def __init__(self, node: Node, on_stop: Callable[[], None]) -> None:
        self.stopped = False
        self.reason = ''  # why it is stopped
        self.stopped_by = ''  # the node that did it, or the nodes of which one did it
        self._node, self._on_stop = node, on_stop
        self._state = node.create_publisher(Bool, STATE, _latched())
        self._status = node.create_publisher(DiagnosticStatus, STATUS, _latched())
        node.create_service(SetBool, SWITCH, self._asked)
        node.create_subscription(Bool, SWITCH, self._pressed, 10)
        # First told by the timer, so once the node spins: who has heard it counts on hearing it again.
        node.create_timer(TOLD_EVERY, self._tell, clock=_steady())
        self._status.publish(self.status())

    def status(self) -> DiagnosticStatus:
        """How it stands: OK or ERROR, the reason as its message, and `stopped` and `by` as values."""
        status = DiagnosticStatus(level=DiagnosticStatus.OK, message='released')
        status.name = f'{self._node.get_fully_qualified_name()[1:]}: emergency stop'
        status.hardware_id = self._node.get_namespace().strip('/') or 'humanoid'
        if self.stopped:
            status.level, status.message = DiagnosticStatus.ERROR, self.reason
        values = {'stopped': 'true' if self.stopped else 'false', 'by': self.stopped_by}
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        return status

    def _tell(self) -> None:
        self._state.publish(Bool(data=self.stopped))

    def _asked(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if request.data:
            self._stop()
            self._explain('{} called the service', client_nodes(self._node, SWITCH))
            response.message = f'stopped: {self.reason}'
        else:
            self._release()
            response.message = 'released'
        response.success = True
        return response

    def _pressed(self, button: Bool) -> None:
        if button.data:
            self._stop()
            self._explain('{} pressed the button', publisher_nodes(self._node, SWITCH))

    def _stop(self) -> None:
        """Stopping twice stops twice: what has come to move in between is told to hold."""
        changed, self.stopped = not self.stopped, True
        self._on_stop()
        self._tell()
        if changed:
            self._node.get_logger().warning('EMERGENCY STOP')

    def _explain(self, reason: str, nodes: Sequence[str]) -> None:
        """Tell why it was thrown; the first reason stays until the release."""
        if not self.reason:
            self.stopped_by = brief(one_of(nodes))
            self.reason = reason.format(self.stopped_by)
            self._status.publish(self.status())

    def _release(self) -> None:
        changed, self.stopped = self.stopped, False
        self.reason = self.stopped_by = ''
        self._tell()
        self._status.publish(self.status())
        if changed:
            self._node.get_logger().warning('Emergency stop released')


class Stand(Enum):
    UNHEARD = 'unheard'  # of a robot without a switch, so far
    RELEASED = 'released'
    STOPPED = 'stopped'
    LOST = 'lost'  # it was heard, and is no more


class StopListener:
    """How the switch stands, as a server knows it; `on_stop` is called when it is thrown, or is gone."""

    def __init__(self, node: Node, on_stop: Callable[[], None]) -> None:
        self._stand = Stand.UNHEARD
        self._missed = 0
        self._node, self._on_stop = node, on_stop
        self._button = node.create_publisher(Bool, SWITCH, 10)
        node.create_subscription(Bool, STATE, self._hear, _latched())
        node.create_timer(TOLD_EVERY, self._look, clock=_steady())

    @property
    def stopped(self) -> bool:
        return self._stand in (Stand.STOPPED, Stand.LOST)

    @property
    def refusal(self) -> str | None:
        """Why nothing may move, or None where it may."""
        if self._stand is Stand.LOST:
            return f'emergency stop: {GONE} Once it is back, {SWITCH} is to be called with false'
        return REFUSAL if self.stopped else None

    @property
    def ended(self) -> str:
        """What the results of goals say that it has ended."""
        return f'{ENDED}: {GONE}' if self._stand is Stand.LOST else ENDED

    def _hear(self, state: Bool) -> None:
        self._missed = 0
        if state.data:
            self._stand = Stand.STOPPED
            self._on_stop()
        elif self._stand is Stand.LOST:
            self._button.publish(Bool(data=True))
        else:
            self._stand = Stand.RELEASED

    def _look(self) -> None:
        """Looks are counted, not seconds: a server that had no time to look has missed nothing yet."""
        if self._stand in (Stand.UNHEARD, Stand.LOST):
            return
        self._missed += 1
        if self._missed > MISSED:
            self._stand = Stand.LOST
            self._node.get_logger().error(f'EMERGENCY STOP: {GONE}')
            self._on_stop()
