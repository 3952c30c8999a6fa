"""The switch of the emergency stop, for the node that owns the motors."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from humanoid.emergency.listener import StopListener
from humanoid.emergency.names import STATE, STATUS, SWITCH, TOLD_EVERY, make_latched_qos, steady
from humanoid.graph import client_nodes, one_of, publisher_gid, publisher_nodes, subscriber_nodes
from humanoid.text import brief


class StopSwitch:
    """Calls `on_stop` as soon as the switch is thrown, or another publisher says "stopped".

    On `emergency_stopped` it publishes only its own state; the status also covers the other publishers.
    """

    def __init__(self, node: Node, on_stop: Callable[[], None]) -> None:
        self._node, self._on_stop = node, on_stop
        self._thrown = False
        self._reason = ''  # why the switch was thrown
        self._by = ''  # the node that has thrown the switch, or a phrase that names the possible nodes
        self._told = DiagnosticStatus()  # the last status
        self._state = node.create_publisher(Bool, STATE, make_latched_qos())
        self._status = node.create_publisher(DiagnosticStatus, STATUS, make_latched_qos())
        node.create_service(SetBool, SWITCH, self._answer)
        node.create_subscription(Bool, SWITCH, self._on_press, 10)
        self._others = StopListener(node, on_stop, press=self._throw_for_the_lost)
        # The timer, not the constructor, publishes the first state: listeners expect repetitions after it.
        node.create_timer(TOLD_EVERY, self._tell, clock=steady())
        self._tell_why()

    @property
    def stopped(self) -> bool:
        """True if this switch or another publisher has stopped the robot."""
        return self._thrown or self._others.stopped

    @property
    def reason(self) -> str:
        """Why the robot is stopped; '' if it is not."""
        if self._thrown:
            return self._reason
        publisher = self._others.stopped_by
        return f'{publisher.node} says so on {STATE}' if publisher is not None else self._others.why

    def _answer(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if request.data:
            self._throw()
            self._explain('called the service', client_nodes(self._node, SWITCH))
            response.success, response.message = True, f'stopped: {self.reason}'
        else:
            self._release()
            response.success = not self.stopped
            response.message = f'still stopped: {self.reason}' if self.stopped else 'released'
        return response

    def _on_press(self, button: Bool, info: Mapping[str, object]) -> None:
        if button.data:
            self._throw()
            nodes = publisher_nodes(self._node, SWITCH, publisher_gid(info))
            listening = set(nodes) <= set(subscriber_nodes(self._node, STATE))
            self._explain('had lost the switch' if listening else 'pressed the button', nodes)

    def _throw_for_the_lost(self) -> None:
        self._throw()
        self._reason = self._reason or self._others.why
        self._others.settle()
        self._tell_why()

    def _throw(self) -> None:
        """Throw the switch. Call `on_stop` even if it was thrown already: something may have moved since."""
        changed, self._thrown = not self._thrown, True
        self._on_stop()
        self._tell_state()
        if changed:
            self._node.get_logger().warning('EMERGENCY STOP')

    def _explain(self, what: str, nodes: list[str]) -> None:
        """Publish why the switch was thrown; the first reason stays until the release."""
        if not self._reason:
            self._by = brief(one_of(nodes))
            self._reason = f'{self._by} {what}'
        self._tell_why()

    def _release(self) -> None:
        changed, self._thrown = self._thrown, False
        self._reason = self._by = ''
        self._tell()
        if changed:
            self._node.get_logger().warning('Emergency stop released')

    def _tell(self) -> None:
        self._tell_state()
        self._tell_why()

    def _tell_state(self) -> None:
        self._state.publish(Bool(data=self._thrown))

    def _tell_why(self) -> None:
        """Publish the status if it has changed: level, reason, and the values `stopped` and `by`."""
        status = DiagnosticStatus(level=DiagnosticStatus.OK, message='released')
        status.name = f'{self._node.get_fully_qualified_name()[1:]}: emergency stop'
        status.hardware_id = self._node.get_namespace().strip('/') or 'humanoid'
        by, publisher = self._by, self._others.stopped_by
        if not self._thrown and publisher is not None:
            by = publisher.node
        if self.stopped:
            status.level, status.message = DiagnosticStatus.ERROR, self.reason
        values = {'stopped': 'true' if self.stopped else 'false', 'by': by}
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        if status != self._told:
            self._told = status
            self._status.publish(status)
