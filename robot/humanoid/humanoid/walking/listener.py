"""How a server hears that the robot has fallen, or stands again."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import Bool

from humanoid.emergency.names import latched
from humanoid.walking.names import FALLEN, LIES


class FallListener:
    """Whether the robot lies on the floor; `on_fall` is called when a robot that stood has fallen.

    A robot that cannot fall tells nothing, and stands.
    """

    def __init__(self, node: Node, on_fall: Callable[[], None]) -> None:
        self.fallen = False
        self._on_fall = on_fall
        node.create_subscription(Bool, FALLEN, self._hear, latched())

    @property
    def refusal(self) -> str | None:
        """Why no goal is taken, or None if the robot stands."""
        return LIES if self.fallen else None

    def _hear(self, told: Bool) -> None:
        self.fallen = told.data
        if told.data:
            self._on_fall()
