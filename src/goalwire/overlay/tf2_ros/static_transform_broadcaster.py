"""tf2_ros.StaticTransformBroadcaster: publishes transforms that never change."""

from __future__ import annotations

from collections.abc import Iterable

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage

from tf2_ros.transform_broadcaster import as_list

__all__ = ['StaticTransformBroadcaster']


class StaticTransformBroadcaster:
    """Publishes transforms on /tf_static, also for late subscribers.

    Each message has all transforms sent so far, one for each child frame, since the publisher keeps only one
    message for late subscribers.
    """

    def __init__(self, node: Node, qos: QoSProfile | int | None = None) -> None:
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.pub_tf = node.create_publisher(TFMessage, '/tf_static', latched if qos is None else qos)
        self._sent: dict[str, TransformStamped] = {}

    def sendTransform(self, transform: TransformStamped | Iterable[TransformStamped]) -> None:
        """Send one transform or several, together with the transforms sent before."""
        self._sent.update({one.child_frame_id: one for one in as_list(transform)})
        self.pub_tf.publish(TFMessage(transforms=list(self._sent.values())))
