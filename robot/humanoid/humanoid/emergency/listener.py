"""How a server hears the emergency stop."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy
from rclpy.task import Future
from std_msgs.msg import Bool

from humanoid.emergency.names import ENDED, REFUSAL, STATE, SWITCH, TOLD_EVERY, make_latched_qos, steady
from humanoid.emergency.votes import MISSED, Publisher, StopVotes
from humanoid.graph import full_name, has_service, one_of, publisher_gid


class StatePublishers:
    """The publishers of `emergency_stopped`, looked up in the ROS graph."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._known: dict[bytes, Publisher] = {}
        self._may_look = True  # `find` may ask the graph once between two calls of `look`

    @property
    def have_switch(self) -> bool:
        """True if a switch was among the publishers at the last look."""
        return any(publisher.is_switch for publisher in self._known.values())

    def look(self) -> Mapping[bytes, Publisher]:
        """Look up the publishers in the ROS graph; return them by their gids."""
        known = {}
        for info in self._node.get_publishers_info_by_topic(STATE):
            gid, name, namespace = bytes(info.endpoint_gid), info.node_name, info.node_namespace
            before = self._known.get(gid)
            is_switch = before is not None and before.is_switch
            is_switch = is_switch or has_service(self._node, name, namespace, SWITCH)
            is_latched = info.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
            known[gid] = Publisher(gid, full_name(name, namespace), is_switch, is_latched)
        self._known, self._may_look = known, True
        return known

    def find(self, info: Mapping[str, object]) -> Publisher:
        """Return the publisher of a message, from the message info of its callback.

        If rclpy does not provide the gid, the publisher is known only if the topic has a single publisher.
        """
        gid = publisher_gid(info)
        if gid is None:
            there = list(self.look().values())
            if len(there) == 1:
                return there[0]
            return Publisher(b'', one_of([each.node for each in there]), is_switch=False)
        if gid not in self._known and self._may_look:
            self.look()
            self._may_look = False
        return self._known.get(gid) or Publisher(gid, one_of([]), is_switch=False)


class StopListener:
    """The state of the emergency stop as a server hears it; calls `on_stop` when the robot must stop."""

    def __init__(
        self, node: Node, on_stop: Callable[[], None], press: Callable[[], None] | None = None
    ) -> None:
        """`press` throws the node's own switch, for a node that has one; its own publishers are then ignored.

        Without `press` the listener publishes on the topic `emergency_stop`, the button of all switches.
        """
        self._node, self._on_stop = node, on_stop
        self._votes = StopVotes()
        self._publishers = StatePublishers(node)
        self._ignored = ''
        self._unheard = 0  # looks since there is a switch that has not said how it stands
        self._waiting: list[Future[None]] = []
        if press is None:
            button = node.create_publisher(Bool, SWITCH, 10)
            self._press: Callable[[], None] = lambda: button.publish(Bool(data=True))
        else:
            self._press = press
            self._ignored = node.get_fully_qualified_name()
        # On DDS a transient-local subscription does not match a volatile publisher, so there are two
        # subscriptions. Each publisher is heard by one of them only: two would mix up its messages' order.
        node.create_subscription(Bool, STATE, self._hear_latched, make_latched_qos())
        node.create_subscription(Bool, STATE, self._hear_volatile, 1)
        node.create_timer(TOLD_EVERY, self._look, clock=steady())

    @property
    def stopped(self) -> bool:
        return self._votes.stopped

    @property
    def stopped_by(self) -> Publisher | None:
        """The publisher that says "stopped"; None if no publisher does."""
        return self._votes.stopped_by

    @property
    def why(self) -> str:
        """Why the robot is stopped; '' if it is not, or if its own switch has simply been thrown."""
        publisher = self._votes.stopped_by
        if publisher is None:
            return self._votes.lost
        return '' if publisher.is_switch else f'{publisher.node} says so on {STATE}'

    @property
    def refusal(self) -> str | None:
        """The reason why goals are refused, or None if the robot may move."""
        if self._votes.stopped_by is not None:
            return f'emergency stop: {self.why} and has to take it back' if self.why else REFUSAL
        if self.stopped:
            return f'emergency stop: {self.why} Once it is back, {SWITCH} is to be called with false'
        if self._is_unknown:
            return 'emergency stop: its switch has not said yet how it stands'
        return None

    @property
    def _is_unknown(self) -> bool:
        return self._publishers.have_switch and not self._votes.knows_switch

    async def until_known(self) -> None:
        """Wait until a switch in the ROS graph has said how it stands, a second at most.

        A switch speaks a moment after it was started. Until then goals would be refused, and their clients
        could not know why.
        """
        while self._is_unknown and self._unheard <= MISSED:
            change: Future[None] = Future()
            self._waiting.append(change)
            await change

    def _wake(self) -> None:
        waiting, self._waiting = self._waiting, []
        for change in waiting:
            change.set_result(None)

    @property
    def has_heard(self) -> bool:
        """True if a switch has published its state, or if the ROS graph shows no switch."""
        self._publishers.look()
        return self._votes.knows_switch or not self._publishers.have_switch

    @property
    def ended(self) -> str:
        """The text with which the results of goals explain that the emergency stop ended them."""
        return f'{ENDED}: {self.why}' if self.why else ENDED

    def settle(self) -> None:
        """Forget the lost publisher: this node's switch was thrown for it and now keeps the robot stopped."""
        self._votes.lost = ''

    def _hear_latched(self, state: Bool, info: Mapping[str, object]) -> None:
        publisher = self._publishers.find(info)
        if publisher.is_latched is not False:
            self._hear(publisher, state)

    def _hear_volatile(self, state: Bool, info: Mapping[str, object]) -> None:
        publisher = self._publishers.find(info)
        if not publisher.is_latched:
            self._hear(publisher, state)

    def _hear(self, publisher: Publisher, state: Bool) -> None:
        if publisher.node == self._ignored:
            return
        throw = self._votes.hear(publisher, stopped=state.data)
        if state.data:
            self._on_stop()
        if throw:
            self._press()
        self._wake()

    def _look(self) -> None:
        if self._votes.look(self._publishers.look()):
            self._node.get_logger().error(f'EMERGENCY STOP: {self._votes.lost}')
            self._on_stop()
            self._press()
        self._unheard = self._unheard + 1 if self._is_unknown else 0
        self._wake()
