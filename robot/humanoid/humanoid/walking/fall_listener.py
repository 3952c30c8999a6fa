"""Informs a server when the robot has fallen, and when it stands again."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import Bool

from humanoid.emergency.names import make_latched_qos
from humanoid.walking.names import FALLEN, LIES


class FallListener:
    """Knows if the robot lies on the floor; calls `on_fall` when it has fallen.

    A robot that cannot fall publishes nothing, and counts as standing.
    """

    def __init__(self, node: Node, on_fall: Callable[[], None]) -> None:
        self.fallen = False
        self._on_fall = on_fall
        node.create_subscription(Bool, FALLEN, self._hear, make_latched_qos())

    @property
    def refusal(self) -> str | None:
        """The reason why goals are refused while the robot lies on the floor; None if it stands."""
        return LIES if self.fallen else None

    def _hear(self, told: Bool) -> None:
        self.fallen = told.data
        if told.data:
            self._on_fall()
