"""tf2_ros.StaticTransformListener: fills a buffer from /tf_static only."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.qos import QoSProfile
from tf2_py import BufferCore

from tf2_ros.transform_listener import DEFAULT_STATIC_TF_TOPIC, TransformListener

__all__ = ['StaticTransformListener']


class StaticTransformListener(TransformListener):
    """A TransformListener that listens only to /tf_static."""

    def __init__(
        self,
        buffer: BufferCore,
        node: Node | None,
        *,
        spin_thread: bool = False,
        static_qos: QoSProfile | int | None = None,
        tf_static_topic: str = DEFAULT_STATIC_TF_TOPIC,
    ) -> None:
        super().__init__(
            buffer,
            node,
            spin_thread=spin_thread,
            static_qos=static_qos,
            tf_static_topic=tf_static_topic,
            static_only=True,
        )
